"""Shapes: what can be traced."""
