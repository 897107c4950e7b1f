"""Easing functions: from 0 at t = 0 to 1 at t = 1. Made by docs/modelling.py."""

from typing import Any

def linear(t: Any) -> Any:
    """Constant speed."""

def in_quad(t: Any) -> Any:
    """Speeds up: a parabola."""

def out_quad(t: Any) -> Any:
    """Slows down: a parabola."""

def in_out_quad(t: Any) -> Any:
    """Speeds up, then slows down: parabolas."""

def in_cubic(t: Any) -> Any:
    """Speeds up as the third power."""

def out_cubic(t: Any) -> Any:
    """Slows down as the third power."""

def in_out_cubic(t: Any) -> Any:
    """Speeds up, then slows down, as the third power."""

def in_quart(t: Any) -> Any:
    """Speeds up as the fourth power."""

def out_quart(t: Any) -> Any:
    """Slows down as the fourth power."""

def in_out_quart(t: Any) -> Any:
    """Speeds up, then slows down, as the fourth power."""

def in_quint(t: Any) -> Any:
    """Speeds up as the fifth power."""

def out_quint(t: Any) -> Any:
    """Slows down as the fifth power."""

def in_out_quint(t: Any) -> Any:
    """Speeds up, then slows down, as the fifth power."""

def in_sine(t: Any) -> Any:
    """Speeds up like a swing from its turning point."""

def out_sine(t: Any) -> Any:
    """Slows down like a swing to its turning point."""

def in_out_sine(t: Any) -> Any:
    """Half a swing, from one turning point to the other."""

def in_expo(t: Any) -> Any:
    """Doubles every tenth of the way."""

def out_expo(t: Any) -> Any:
    """Halves the remainder every tenth of the way."""

def in_out_expo(t: Any) -> Any:
    """Doubles every twentieth of the way, then halves the remainder."""

def in_circ(t: Any) -> Any:
    """Speeds up: a quarter of a circle, level at the start."""

def out_circ(t: Any) -> Any:
    """Slows down: a quarter of a circle, level at the end."""

def in_out_circ(t: Any) -> Any:
    """Two quarters of circles, level at both ends."""

def in_elastic(t: Any, k: float = ...) -> Any:
    """Oscillates with period k and growing amplitude, then moves."""

def out_elastic(t: Any, k: float = ...) -> Any:
    """Overshoots, then oscillates with period k and shrinking amplitude."""

def in_out_elastic(t: Any, k: float = ...) -> Any:
    """Oscillates at both ends, with half the period k."""

def in_back(t: Any) -> Any:
    """Draws back by a tenth first."""

def out_back(t: Any) -> Any:
    """Overshoots by a tenth, then returns."""

def in_out_back(t: Any) -> Any:
    """Draws back first, and overshoots at the end."""

def in_bounce(t: Any) -> Any:
    """Bounces higher and higher."""

def out_bounce(t: Any) -> Any:
    """Falls and bounces lower and lower."""

def in_out_bounce(t: Any) -> Any:
    """Bounces at both ends."""

def in_square(t: Any) -> Any:
    """Jumps at the end."""

def out_square(t: Any) -> Any:
    """Jumps at the start."""

def in_out_square(t: Any) -> Any:
    """Jumps in the middle."""
