"""Questions about a solved sensor: its limits, its bench data, codes over time, spectra."""
