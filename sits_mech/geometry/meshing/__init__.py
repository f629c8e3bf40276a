"""Structured meshes and those of the user."""
