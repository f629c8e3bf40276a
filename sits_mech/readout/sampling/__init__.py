"""Codes of a converter over time."""
