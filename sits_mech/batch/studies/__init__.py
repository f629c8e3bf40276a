"""Files of studies: what they ask, their cases, what they refuse."""
