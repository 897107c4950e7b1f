"""Shapes: meshes, implicit surfaces, NURBS surfaces and tubes."""
