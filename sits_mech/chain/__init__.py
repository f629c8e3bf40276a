"""From a wrench through the pose to inductances: one load, grids of loads, plans, derivatives."""
