"""A twin for robots and firmware."""
