"""Algorithm 3 of Olsson 2020 as printed, one sample at a time, without its decompositions of all samples.

The strongest direction w1 of the m rows is the first eigenvector of their 6x6 Gram matrix, and removing a row
takes its outer product off that matrix. So that not all rows need be compared with each w1, those that stand
first in the order of removal are held ready: `_front` says which, and for how long they suffice.

Rounding is bounded, and where the bound leaves a choice open, the choice is the printed one, by a singular
value decomposition. So the result is that of the printed form, also where two eigenvalues meet.
"""

import math

import numpy as np
from scipy.linalg.lapack import dsyev

from imubench.arrays import Array
from imubench.estimators.selection_gyro import Index
from imubench.estimators.selection_order import choose, directions, removal_order

FRONT = 512  # rows held ready; their products with w1 take a microsecond
CLOSE = 0.02  # rad that w1 may leave the subspace for which the front was made
AHEAD = 200.0  # removals that the subspace should last for
UNSURE = 0.001  # rad of doubt about w1 from which no bound is trusted
SIGMAS = 8.0  # of rounding, which grows as the square root of the operations (Higham, Mary, SIAM J. Sci. Comput. 2019)
EPS = float(np.finfo(float).eps)


def printed(rows: Array, penalty: Array, n_max: int) -> Index:
    """Return the indices (<= n_max,), ascending, of the rows (m, 6) that Algorithm 3 keeps."""
    order = removal_order(penalty)
    left = _Left(rows[order], order)
    size = FRONT
    while left.count > n_max:
        front = left.front(size)
        removed, why = _advance(left.gram, front, left.rounding, left.count - n_max)
        left.remove(front.places[removed])
        if why == "undecided":
            left.remove_one(left.as_printed(penalty))
        elif why == "none" and front.complete:
            left.remove_one(int(left.present.argmax()))  # nothing is coherent: see `choose`
        size = 4 * size if why == "none" and not removed else FRONT
    return np.sort(left.ids[left.present])


class _Front:
    """The rows that come first in the order of removal among those that can be coherent with w1 for now.

    A row at more than 60 degrees + CLOSE from a subspace is not coherent with any w1 within CLOSE of it.
    """

    def __init__(self, rows: Array, unit: Array, gram: Array, size: int):
        values, vectors, _ = dsyev(gram)
        per_row = values.sum() / max(1, len(rows))
        # Directions that can be the strongest one before AHEAD rows are gone.
        self.span = vectors[:, values > values[5] - AHEAD * per_row]
        near = np.square(self.span.T @ unit).sum(axis=0) > math.cos(math.pi / 3 + CLOSE) ** 2
        places = np.flatnonzero(near)
        self.complete = places.size <= size
        self.places = places[:size]  # (k,) in the order of removal
        self.unit = np.ascontiguousarray(unit[:, self.places])  # (6, k)
        held = rows[self.places]
        self.products = held[:, :, None] * held[:, None, :]  # (k, 6, 6)


class _Left:
    """The rows that are left, in the order of removal, with their Gram matrix."""

    def __init__(self, rows: Array, ids: Index):
        self.rows, self.ids = rows, ids
        self.unit = np.ascontiguousarray(directions(rows).T)  # (6, m), zero where the row has gone
        self.present = np.ones(len(rows), dtype=bool)
        self.count = len(rows)
        self._sum_up()

    def _sum_up(self) -> None:
        self.gram = np.asfortranarray(self.rows.T @ self.rows)
        # One rounding for each row summed up and each taken off, some 64 in a 6x6 decomposition, twice as much in the
        # printed form's own one; an error E of the matrix turns w1 by at most 2 |E| / gap (Davis, Kahan).
        self.rounding = 3 * EPS * (64 + SIGMAS * math.sqrt(2 * self.count)) * float(np.trace(self.gram))

    def front(self, size: int) -> _Front:
        """Return the first `size` rows that can be coherent; sum up anew when half of the rows have gone."""
        if 2 * self.count <= len(self.rows):
            self.rows, self.ids = self.rows[self.present], self.ids[self.present]
            self.unit = np.ascontiguousarray(self.unit[:, self.present])
            self.present = np.ones(self.count, dtype=bool)
            self._sum_up()
        return _Front(self.rows, self.unit, self.gram, size)

    def remove(self, places: Index) -> None:
        """Mark rows as gone that have been taken off the Gram matrix."""
        self.present[places] = False
        self.unit[:, places] = 0.0
        self.count -= places.size

    def remove_one(self, place: int) -> None:
        """Remove one row, also from the Gram matrix."""
        self.gram -= np.outer(self.rows[place], self.rows[place])
        self.remove(np.array([place]))

    def as_printed(self, penalty: Array) -> int:
        """Return the place of the row that the printed form removes next, from all rows in the order of time."""
        places = np.flatnonzero(self.present)
        places = places[np.argsort(self.ids[places])]
        return int(places[choose(self.rows[places], penalty[self.ids[places]])])


def _advance(gram: Array, front: _Front, rounding: float, most: int) -> tuple[list[int], str]:
    """Take rows of the front off `gram` (6, 6), in place, as long as their choice is certain.

    Returns the numbers of the rows within the front, and what ended it: "done", `most` rows removed; "stale", w1
    has left the subspace; "none", no row of the front is coherent; "undecided", rounding could change the choice.
    """
    unit, products, across = front.unit, front.products, front.span.T
    inside = math.cos(CLOSE - 2 * UNSURE) ** 2
    c = np.empty(unit.shape[1])
    removed: list[int] = []
    while len(removed) < most:
        values, vectors, _ = dsyev(gram)
        gap = float(values[5] - values[4])
        if rounding >= UNSURE * gap:
            return removed, "undecided"
        strongest, error = vectors[:, 5], rounding / gap
        along = across.dot(strongest)
        if along.dot(along) < inside:
            return removed, "stale"
        np.abs(strongest.dot(unit, out=c), out=c)
        first = int((c > 0.5 - error).argmax()) if c.size else 0
        if not c.size or c[first] <= 0.5 - error:
            return removed, "none"
        if c[first] <= 0.5 + error:
            return removed, "undecided"
        unit[:, first] = 0.0
        np.subtract(gram, products[first], gram)
        removed.append(first)
    return removed, "done"
