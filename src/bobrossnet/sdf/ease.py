"""Easing functions: from 0 at t = 0 to 1 at t = 1, of numbers and of arrays."""

from bobrossnet.sdf.words import easing_words

globals().update(easing_words())
__all__ = list(easing_words())  # noqa: PLE0605
