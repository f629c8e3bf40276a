"""Nested meshes, the extrapolated pose and its error, histories on them."""
