"""Easing functions of numbers and arrays, from 0 at t = 0 to 1 at t = 1. Editors read ease.pyi."""

from bobrossnet.sdf.words import easing_words

_words = easing_words()
globals().update(_words)
__all__ = [*_words]
