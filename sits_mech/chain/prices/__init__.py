"""What a model leaves out and what a request will cost."""
