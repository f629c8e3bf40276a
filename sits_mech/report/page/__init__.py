"""The HTML page with its explorer."""
