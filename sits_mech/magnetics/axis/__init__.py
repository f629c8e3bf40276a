"""Discs over coils on one axis."""
