"""What a model leaves out of the magnetics, with its size: ends of a section, distant conductors."""
