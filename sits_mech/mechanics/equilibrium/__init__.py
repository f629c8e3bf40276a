"""Newton, load control and paths to an equilibrium."""
