"""Elements, their assembly and elimination."""
