"""Learning: networks, losses, shapes to learn from, training, evaluation. The only package that imports torch."""
