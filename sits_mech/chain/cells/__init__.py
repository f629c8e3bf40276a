"""Cells on one pad: what each reads of the others."""
