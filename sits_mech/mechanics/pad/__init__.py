"""Meshes of pads."""
