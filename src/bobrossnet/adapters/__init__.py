"""Other people's files and tracers."""
