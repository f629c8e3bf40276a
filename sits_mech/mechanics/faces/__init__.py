"""Contact of faces, with friction."""
