"""Finished pictures: single renderings, thumbnails of a folder, turntables, and notebooks."""
