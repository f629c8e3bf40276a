"""Ferrite cores beside the coils."""
