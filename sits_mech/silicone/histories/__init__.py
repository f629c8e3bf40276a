"""Rate and softening from tests over time."""
