"""Parts of the models in the section y = 0: coils, bars of plates, finite elements."""
