"""Root of a function of one number, without SciPy's optimisers, which take longer to import than a fit."""

from __future__ import annotations

from collections.abc import Callable


def root(
    f: Callable[[float], float],
    one: tuple[float, float],
    other: tuple[float, float],
    *,
    absolute: float,
    relative: float = 0.0,
) -> float:
    """Root of f between two points (x, f(x)) with f of opposite signs: inverse quadratic interpolation or bisection.

    T. R. Chandrupatla, "A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function without
    using derivatives", Adv. Eng. Softw. 28 (1997). The first step is a secant: the functions here are nearly linear.
    """
    (a, fa), (b, fb) = one, other
    t = fa / (fa - fb)
    while True:
        x = a + t * (b - a)
        fx = f(x)
        if (fx > 0) == (fa > 0):
            c, fc = a, fa
        else:
            c, fc, b, fb = b, fb, a, fa
        a, fa = x, fx
        best, least = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        share = 0.5 * (absolute + relative * abs(best)) / abs(b - a)
        if share > 0.5 or least == 0:
            return best
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        t = 0.5
        if phi**2 < xi and (1 - phi) ** 2 < 1 - xi:
            t = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        t = min(max(t, share), 1 - share)
