"""Rendering: cameras, pixel orders, tracers, G-buffers, progressive pictures."""
