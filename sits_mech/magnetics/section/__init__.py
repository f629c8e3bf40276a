"""Parts of the model in plane section."""
