"""Find out which sensor was built: what a bench shows of it, and the unknowns that explain it."""
