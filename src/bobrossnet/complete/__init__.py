"""Completion: networks that fill in the pixels that were not traced."""
