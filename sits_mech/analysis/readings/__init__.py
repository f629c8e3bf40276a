"""Readings of a bench and of terminals: tables, codes, henries, forces."""
