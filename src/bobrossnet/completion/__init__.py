"""Completion of the untraced pixels, by networks and by classical fillings."""
