"""The parts of a sensor: coils, target and other metal, pad, cover, slots, and what touches it."""
