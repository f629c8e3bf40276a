"""The finite element model of the field: mesh, source, solution."""
