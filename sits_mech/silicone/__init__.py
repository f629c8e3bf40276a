"""Laws of silicone, fits to tests, stability."""
