"""Derivatives through the chain: by sizes, silicone, load and temperature."""
