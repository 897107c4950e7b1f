"""Shared utilities: errors, paths, atomic writes, threads, interrupts, progress."""
