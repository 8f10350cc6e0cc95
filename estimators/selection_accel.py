"""Which accelerometer samples tell most about a hinge: Olsson 2020, Algorithm 3, and its batched form.

Three ways to thin the samples out, by name: `printed`, the algorithm of the paper, one sample at a time,
on its 6x6 Gram matrix; `literal`, the same with a singular value decomposition for each removal, slow and
its yardstick; `batched`, what the authors' code does, which is another algorithm.
"""

import math
from collections.abc import Callable

import numpy as np

from imubench.arrays import Array
from imubench.errors import unknown
from imubench.estimators.selection_gyro import HALF_WIDTH, Index, squared_norms
from imubench.estimators.selection_order import choose, coherence, removal_order
from imubench.estimators.selection_printed import printed

ENERGY_THRESHOLD = 1.0  # E_th in rad^2/s^2, section 7.3


def penalties(gyro1: Array, gyro2: Array, half_width: int = HALF_WIDTH) -> Array:
    """Return min(E1, E2) (n,) in rad^2/s^2, eq. (45) and (46), from gyro (n, 3) in rad/s.

    E is the mean of ||w||^2 over 2 `half_width` + 1 samples; infinite within `half_width` of the ends.
    """
    return window_penalties(squared_norms(gyro1), squared_norms(gyro2), half_width)


def window_penalties(squared1: Array, squared2: Array, half_width: int) -> Array:
    """Return the penalties (n,) from ||w||^2 (n,); a value depends on its own window alone, to the last bit."""
    penalty = np.full(squared1.size, np.inf)
    inside = squared1.size - 2 * half_width
    if inside > 0:
        means = []
        for squared in (squared1, squared2):
            total = squared[:inside].copy()
            for shift in range(1, 2 * half_width + 1):
                total += squared[shift : shift + inside]
            means.append(total / (2 * half_width + 1))
        penalty[half_width : half_width + inside] = np.minimum(*means)
    return penalty


def literal(rows: Array, penalty: Array, n_max: int) -> Index:
    """Thin out as printed, with a singular value decomposition for each removal; as `thin`."""
    kept = np.arange(len(rows))
    while kept.size > n_max:
        kept = np.delete(kept, choose(rows[kept], penalty[kept]))
    return kept


def batched(rows: Array, penalty: Array, n_max: int) -> Index:
    """Thin out in batches, as the authors' code does; as `thin`.

    With m rows left and singular values s1 >= s2, the floor(m s2 / s1) + 1 coherent rows of largest penalty go
    at once, or all coherent ones, but never more than m - `n_max`. If none is coherent, one row goes, that of
    largest penalty.
    """
    kept = removal_order(penalty)
    rows = rows[kept]
    while kept.size > n_max:
        values, vectors = np.linalg.eigh(rows.T @ rows)
        ratio = math.sqrt(max(values[4], 0.0) / values[5]) if values[5] > 0 else 1.0
        size = min(math.floor(ratio * kept.size) + 1, kept.size - n_max)
        gone = np.flatnonzero(coherence(rows, vectors[:, 5]) > 0.5)[:size]
        stay = np.ones(kept.size, dtype=bool)
        stay[gone if gone.size else 0] = False
        kept, rows = kept[stay], rows[stay]
    return np.sort(kept)


FORMS: dict[str, Callable[[Array, Array, int], Index]] = {"printed": printed, "literal": literal, "batched": batched}


def thin(rows: Array, penalty: Array, n_max: int, form: str = "printed") -> Index:
    """Return the indices (<= n_max,), ascending, of the rows that are left when coherent ones are removed.

    rows (m, 6) of [a1, -a2], eq. (53), in m/s^2; penalty (m,). Raises `InputError` for an unknown form.
    Source: Olsson 2020, Algorithm 3, lines 5 to 10.
    """
    if form not in FORMS:
        raise unknown("form of Algorithm 3", form, FORMS)
    return FORMS[form](rows, penalty, n_max)


def pick_accel(
    rows: Array, penalty: Array, n_max: int, threshold: float = ENERGY_THRESHOLD, form: str = "printed"
) -> Index:
    """Return the indices (<= n_max,), ascending, that Algorithm 3 keeps; arguments as `thin`.

    Samples of a penalty above `threshold` in rad^2/s^2 go first, but only if there are more than `n_max` samples.
    """
    if len(rows) <= n_max:
        return np.arange(len(rows))
    slow = np.flatnonzero(penalty <= threshold)
    return slow[thin(rows[slow], penalty[slow], n_max, form)]
