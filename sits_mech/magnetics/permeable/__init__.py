"""Permeable plates in space: steel, ferrite, filled rubber, by a potential on their surfaces."""
