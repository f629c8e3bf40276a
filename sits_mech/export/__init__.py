"""Formats for other programs, found as entry points."""
