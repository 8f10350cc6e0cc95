"""The search for the oscillations of an r: one frequency after the other, as long as the evidence grows.

Columns of many frequencies are compared on a grid, those of the best few exactly; the best is moved to the top of the
evidence by Newton's steps. On a stream, frequencies start from where they were in the window before.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.estimators.sliding_lines import FIXED, LINE_STD, R_STD, Lines, evidence
from imubench.estimators.sliding_rows import Rows
from imubench.estimators.sliding_waves import Waves

LOWEST, HIGHEST = 0.1, 6.0  # Hz
LINES = 4  # at most
FEW = 8  # frequencies of a grid, whose evidence is told exactly
STEPS = 8  # of Newton, at most
ENOUGH = 0.01  # nat, for columns to be made anew after a step of Newton: 0.14 standard deviations of a frequency
NEAR = 0.1  # nat, likewise for a window that follows on another
EXPLAINED = 1.2  # times the noise's power in the residuals: over a window of 600 rows three times its std above 1
BETWEEN = 0.5  # of what a frequency of the grid gains; more than one between two of the grid can gain on top


@dataclass(frozen=True)
class Found:
    """Some frequencies, and what the samples say beside them."""

    frequency: Array  # (lines,) Hz
    A: Array  # (rows * 3, p), columns of unit prior: r0, gravity, six of each frequency
    gram: Array  # (p, p), A^T A
    along: Array  # (p,), A^T y
    evidence: float  # nat, the choice of frequencies not taken off
    x: Array  # (p,), the sizes of the columns
    power: float  # of the residuals over that of the declared noise
    slopes: Array  # (rows * 3, lines, 6), of the frequencies' columns by their frequency in Hz
    step: Array  # (lines,) Hz, what is left to go; x goes along in proportion


class Search:
    """The oscillations of one kind in the rows of one window."""

    def __init__(self, rows: Rows, felt: bool):
        self.rows, self.felt = rows, felt
        self.y = rows.measured
        self.squares = float(self.y @ self.y)
        self.length = float(rows.time[-1] - rows.time[0])
        self.choice = float(np.log(2 * self.length * (HIGHEST - LOWEST)))  # nat: one of so many frequencies
        fixed = np.hstack([R_STD * rows.held, rows.gravity[1] * rows.tilted])
        self.found = self._weighed(np.zeros(0), fixed, np.zeros((self.y.size, 0, 6)))
        self._scan: tuple[Array, Any, Array] | None = None  # a grid, its columns and their Gram matrices

    @cached_property
    def waves(self) -> Waves:
        """The columns of any oscillation."""
        return Waves(self.rows)

    @property
    def evidence(self) -> float:
        """The evidence in nat, the choice of frequencies taken off."""
        return self._worth(self.found)

    def _worth(self, found: Found) -> float:
        return found.evidence - self.choice * found.frequency.size

    def start(self, frequency: Array) -> None:
        """Take frequencies (lines,) in Hz instead, each moved to the top of the evidence beside it."""
        if frequency.size:
            self.found = self._refined(frequency, slice(0, frequency.size), 0.25 / self.length, NEAR)
        elif self.found.frequency.size:
            self.found = self._weighed(frequency, self.found.A[:, :FIXED], self.found.slopes[:, :0])

    def add(self) -> bool:
        """Add the frequency that raises the evidence most; tell whether it was worth it."""
        count = self.found.frequency.size
        first, found = self._likeliest()
        if found + BETWEEN * (found - self.found.evidence) + 1.0 < self.found.evidence + self.choice:
            return False
        frequency = np.append(self.found.frequency, first)
        one = self._refined(frequency, slice(count, count + 1), 0.5 / self.length)
        if not self._worth(one) > self.evidence:
            return False
        self.found = one
        if count:  # a new one may explain what an old one was bent to
            self.found = self._refined(one.frequency, slice(0, count + 1), 0.25 / self.length)
        return True

    def prune(self) -> None:
        """Leave out frequencies, one after the other, that are no longer worth their choice."""
        while self.found.frequency.size:
            found, count = self.found, self.found.frequency.size
            without = []
            for i in range(count):
                kept = np.delete(np.arange(found.x.size), np.arange(FIXED + 6 * i, FIXED + 6 + 6 * i))
                rest = evidence(found.gram[np.ix_(kept, kept)], found.along[kept], self.squares, self.y.size)
                without.append(float(rest[0]))
            if not max(without) - self.choice * (count - 1) > self.evidence:
                return
            self.start(np.delete(found.frequency, int(np.argmax(without))))

    def _weighed(self, frequency: Array, A: Array, slopes: Array) -> Found:
        gram, along = A.T @ A, A.T @ self.y
        weight, x, power = evidence(gram, along, self.squares, self.y.size)
        return Found(frequency, A, gram, along, float(weight), x, float(power), slopes, np.zeros(frequency.size))

    def _scanned(self) -> tuple[Array, Any, Array]:
        """Return a grid of frequencies (k,) in Hz, columns (k, 6, rows * 3) in single precision, and (k, 6, 6)."""
        if self._scan is None:
            spacing = 0.5 / self.length
            grid = np.arange(max(LOWEST, spacing), min(HIGHEST, 0.4 / self.rows.step), spacing, dtype=float)
            C = LINE_STD * self.waves.scanned(grid, self.felt)
            self._scan = grid, C, (C @ C.transpose(0, 2, 1)).astype(float)
        return self._scan

    def _likeliest(self) -> tuple[float, float]:
        """Return the frequency of a grid in Hz that has the largest evidence beside those found, and that in nat.

        A few are told with what was found integrated out at the power of the noise as it is now; among these, exactly.
        """
        grid, C, CC = self._scanned()
        now, p = self.found, self.found.x.size
        Ay = np.column_stack([now.A, self.y]).astype(np.float32)
        across = (C.reshape(-1, self.y.size) @ Ay).astype(float).reshape(grid.size, 6, p + 1)
        CA, Cy = across[:, :, :p], across[:, :, p]
        root = np.linalg.inv(np.linalg.cholesky(now.gram + now.power * np.eye(p)))
        over, down = CA @ root.T, root @ now.along
        S, b, left = CC - over @ over.transpose(0, 2, 1), Cy - over @ down, self.squares - float(down @ down)
        few = np.argsort(evidence(S, b, left, self.y.size - p)[0])[-FEW:]
        G = np.empty((few.size, p + 6, p + 6))
        G[:, :p, :p], G[:, p:, p:], G[:, p:, :p] = now.gram, CC[few], CA[few]
        G[:, :p, p:] = CA[few].transpose(0, 2, 1)
        along = np.concatenate([np.broadcast_to(now.along, (few.size, p)), Cy[few]], axis=1)
        exact = evidence(G, along, self.squares, self.y.size)[0]
        best = int(np.argmax(exact))
        return float(grid[few[best]]), float(exact[best])

    def _refined(self, frequency: Array, free: slice, width: float, enough: float = ENOUGH) -> Found:
        """Return the `free` ones of frequencies (lines,) in Hz moved to the top of the evidence, by `width` at most.

        Newton's steps. With A the columns, x their sizes, p the power, H = A^T A + p I and, of each frequency, A' and
        u = A' x, the evidence has the slope u^T (y - A x) / p - trace(H^-1 A^T A') and about the curvature
        -(u^T u - u^T A H^-1 A^T u) / p.
        """
        first, best = frequency[free], self.found
        at, step, slope = first, np.zeros(first.size), np.zeros(first.size)
        for i in range(STEPS):
            tried = self._tried(frequency[: free.start], at + step)
            if i == 0 or tried.evidence >= best.evidence:
                at, best = at + step, tried
                slope, curvature = self._bend(best, free.start)
                goal = at + np.linalg.solve(curvature + np.eye(at.size) / width**2, slope)
                step = np.clip(goal, np.maximum(first - width, 0.5 * LOWEST), first + width) - at
            else:
                step = step / 4  # it went too far
            if 0.5 * float(np.abs(slope @ step)) < enough:
                return replace(best, step=np.concatenate([np.zeros(free.start), step]))
        return best

    def _tried(self, kept: Array, frequency: Array) -> Found:
        """Return what the first frequencies found and others in their place make."""
        C, slopes = (LINE_STD * x for x in self.waves.slopes(frequency, self.felt))
        A = np.hstack([self.found.A[:, : FIXED + 6 * kept.size], C.reshape(len(C), -1)])
        slopes = np.concatenate([self.found.slopes[:, : kept.size], slopes], axis=1)
        return self._weighed(np.append(kept, frequency), A, slopes)

    def _bend(self, found: Found, first: int) -> tuple[Array, Array]:
        """Return slope (k,) and curvature (k, k), its sign changed, of the evidence by frequencies from one on."""
        A, x, power = found.A, found.x, found.power
        slopes, start = found.slopes[:, first:], FIXED + 6 * first
        u = np.einsum("nlk,lk->nl", slopes, x[start:].reshape(-1, 6))
        inverse = np.linalg.inv(found.gram + power * np.eye(x.size))
        turned = np.sum(inverse[start:] * (slopes.reshape(len(A), -1).T @ A), axis=1)
        slope = u.T @ (self.y - A @ x) / power - turned.reshape(-1, 6).sum(axis=1)
        Au = A.T @ u
        return slope, (u.T @ u - Au.T @ inverse @ Au) / power

    def answer(self) -> Lines:
        """Return the fit, with a covariance that counts the frequencies among what is unknown."""
        found, rows = self.found, self.rows
        count = found.frequency.size
        gravity = np.full(6, rows.gravity[1])
        prior = np.concatenate([np.full(3, R_STD), gravity, np.full(6 * count, LINE_STD)])
        u = np.einsum("nlk,lk->nl", found.slopes, found.x[FIXED:].reshape(count, 6))
        J = np.hstack([found.A / prior, u])
        loose = np.full(count, 1 / self.length)  # Hz: the search has put each on its peak
        information = J.T @ J / found.power + np.diag(1 / np.concatenate([prior, loose]) ** 2)
        covariance = np.linalg.inv(information)
        inverse = np.linalg.inv(found.gram + found.power * np.eye(found.x.size))
        x = found.x - inverse @ (found.A.T @ (u @ found.step))
        return Lines(
            self.felt,
            self.evidence,
            found.power,
            float(rows.time[0]),
            found.frequency + found.step,
            prior * x,
            covariance,
        )


def fit(rows: Rows, felt: bool, lines: int = LINES, rival: float = -np.inf) -> Lines:
    """Return r0 and as many oscillations, `lines` at most, as the evidence asks for.

    `rival` in nat: an evidence that has to be reached; once as many more, each worth as much as the last, would not do,
    the search ends.
    """
    search = Search(rows, felt)
    left, before = lines, search.evidence
    while left and search.add():
        left -= 1
        if search.evidence + left * (search.evidence - before) < rival:
            break
        before = search.evidence
    return search.answer()


def followed(rows: Rows, last: Lines) -> Lines:
    """Return the fit of a later window with the oscillations of the `last` one, of frequencies near its own.

    Those that are no longer worth it are left out; more are looked for where what is left is more than the noise.
    """
    search = Search(rows, last.felt)
    search.start(last.frequency)
    search.prune()
    while search.found.power > EXPLAINED and search.found.frequency.size < LINES and search.add():
        pass
    return search.answer()
