"""Constants of a silicone from its tests: tension, relaxation, cycles."""
