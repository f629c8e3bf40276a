"""Coils without target: inductance, resistance, field, terminals."""
