"""Coils without target: loops, straight tracks, capacitance."""
