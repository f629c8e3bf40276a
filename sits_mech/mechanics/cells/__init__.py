"""Several rigid targets on one pad, at small strain: forces on them, and touches between them."""
