"""What tracing and completion share: cameras, pixel orders, G-buffers, and files of pictures."""
