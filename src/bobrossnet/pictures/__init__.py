"""Finished pictures: one of a model, many of a folder, a turntable, a notebook's."""
