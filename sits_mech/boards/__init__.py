"""Coils and pours from KiCad boards."""
