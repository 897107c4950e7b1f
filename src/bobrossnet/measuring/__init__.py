"""Measures of scenes, of their parts and of what is picked."""
