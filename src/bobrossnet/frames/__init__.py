"""Frames under a budget: which pixels are traced, when, and what shows them."""
