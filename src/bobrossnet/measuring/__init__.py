"""Measures of scenes, their parts, and picked points."""
