"""The studio: a page on which a scene is changed by hand, previewed at once and solved behind."""
