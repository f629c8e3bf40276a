"""Shapes of coils, plates and pads, and where they touch."""
