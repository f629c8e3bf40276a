"""Maps through solved points: sparse grids, polynomials, kriging, their domains."""
