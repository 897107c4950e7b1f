"""Shared by tracing and completion: cameras, pixel orders, G-buffers, and picture files."""
