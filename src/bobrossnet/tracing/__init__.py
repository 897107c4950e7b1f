"""Tracing: scenes of shapes, their materials, and the tracer."""
