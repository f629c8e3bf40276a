"""Parts of the model in space: divisions, modes, plates near and far, ferrite."""
