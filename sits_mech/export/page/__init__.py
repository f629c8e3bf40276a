"""A calibrated sensor as a page to play with."""
