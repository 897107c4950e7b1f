"""Rendering: cameras, pixel orders, tracers, G-buffers, and pictures of them."""
