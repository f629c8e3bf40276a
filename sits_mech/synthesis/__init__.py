"""Search for a sensor that meets requirements."""
