"""Completion: networks and fillings that fill in the pixels that were not traced."""
