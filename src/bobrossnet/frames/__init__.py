"""Frames under a time budget: the choice of pixels, the calls of tracers, and the completed pictures."""
