"""The expected length of a plane vector under noise, and how it bends: Rice's distribution."""

import math

import numpy as np
from scipy.special import i0e, i1e

from imubench.arrays import Array


def expected_length(length: Array, std: float) -> tuple[Array, Array, Array]:
    """Return E|v + n| for plane vectors v of these lengths and noise n of `std` > 0 on either axis, and its bends.

    Shapes are those of `length`. The bends are its second derivatives by v, along v and across v: its Hessian is
    along u u^T + across (I - u u^T), u = v / |v|. Where v >> n they are those of |v|, 0 and 1 / |v|; at v = 0, where
    |v| has a kink, both are sqrt(pi / 8) / std. Source: Rice, Bell System Technical Journal 24 (1945) 46, section 3.10.
    """
    y = (0.5 * length / std) ** 2
    zero, one = i0e(y), i1e(y)
    scale = math.sqrt(math.pi / 2)
    mean = std * scale * ((1.0 + 2.0 * y) * zero + 2.0 * y * one)
    across = 0.5 * scale / std * (zero + one)
    along = scale / std * zero - across  # the trace is E[1 / |v + n|]
    return np.asarray(mean), np.asarray(along), np.asarray(across)
