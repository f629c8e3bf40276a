"""Answers over loads that change in time."""
