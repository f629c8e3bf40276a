"""A target that bends under its load."""
