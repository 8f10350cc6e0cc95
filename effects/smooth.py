"""Functions of jets that have a derivative everywhere."""

import numpy as np

from imubench.jets import Jet, dot


def magnitude(v: Jet, floor: float) -> Jet:
    """Return sqrt(v . v + floor^2) (n, 1) of vectors (n, m)."""
    square = dot(v, v)
    root = np.sqrt(square.value + floor**2)
    return square.through(root, 0.5 / root)


def beyond(x: Jet, width: float) -> Jet:
    """Return x where it is above zero and nothing where it is below, rounded over `width`: w log(1 + exp(x / w))."""
    return x.through(width * np.logaddexp(0.0, x.value / width), 0.5 * (1 + np.tanh(0.5 * x.value / width)))


def touching(x: Jet, width: float) -> Jet:
    """Return 1 where x is above zero and 0 where it is below, rounded over `width`: 1 / (1 + exp(-x / w))."""
    share = 0.5 * (1 + np.tanh(0.5 * x.value / width))
    return x.through(share, share * (1 - share) / width)
