"""From inductances to readings, and back to forces."""
