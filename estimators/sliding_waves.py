"""What oscillations of r make of the equations, at many frequencies at once.

With r = e q(t), e an axis and q = i exp(-i 2 pi f t), whose real part is the sine and whose imaginary part the cosine,
q' = l q, l = -i 2 pi f, and sums of sliding_rows.py over one spline b, written < >:

    felt:    -< -b' (l q e + q w x e) > - < b (l q w x e + q w x (w x e)) >  =  -([X]x + Y + l <-b' q>) e
    unfelt:  -< -b' q w x e > - < b (q w x (w x e) - l q w x e) >            =  -([X]x + Y) e
    X = < -b' q w > +- l < b q w >,    Y = < b q (w w^T - |w|^2) >

with + if felt. So twelve sums do for both kinds and all axes: three with -b' w, three with b w, six with b w w^T. About
the middle of its spline, q is a phase times a q that is alike for all splines: all sums of a window are one matrix
product, of (12 rows, samples of a spline) and (samples of a spline, frequencies).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.estimators.sliding_rows import Rows
from imubench.estimators.sliding_splines import stencil

AT_ONCE = 24  # frequencies of a scan, whose numbers stay in the cache
PAIRS = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])  # of axes: xx, yy, zz, xy, xz, yz


def oscillations(time: Array, frequency: Array) -> tuple[Array, Array, Array, Array]:
    """Return sin, cos (n, lines, 2), their rates, and the derivatives of both by the frequency in Hz."""
    turn, phase = 2 * np.pi * frequency, 2 * np.pi * np.multiply.outer(time, frequency)
    sine, cosine = np.sin(phase), np.cos(phase)
    by = 2 * np.pi * time[:, None]
    value, rate = np.stack([sine, cosine], axis=-1), np.stack([turn * cosine, -turn * sine], axis=-1)
    value_by = np.stack([by * cosine, -by * sine], axis=-1)
    rate_by = np.stack([2 * np.pi * cosine - turn * by * sine, -2 * np.pi * sine - turn * by * cosine], axis=-1)
    return value, rate, value_by, rate_by


class Waves:
    """The oscillations of one window: `columns` has what each makes of the whitened rows."""

    def __init__(self, rows: Rows):
        self._rows = rows
        m, value, minus = stencil(rows.step)
        width, w = value.size, rows.rate
        parts = np.concatenate([w, w[:, PAIRS[0]] * w[:, PAIRS[1]]], axis=1)  # (n, 9)
        windows = np.lib.stride_tricks.sliding_window_view(parts, width, axis=0)[::m]  # (rows, 9, width)
        count = len(windows)
        self._local = np.empty((count, 12, width))
        self._local[:, :3], self._local[:, 3:] = minus * windows[:, :3], value * windows
        self._minus = minus
        self._near = (np.arange(width) - (width - 1) / 2) * rows.step  # s, about the middle of a spline
        self._middle = (np.arange(count) * m + (width - 1) / 2) * rows.step  # s since the first sample

    def scanned(self, frequency: Array, felt: bool) -> NDArray[np.float32]:
        """Return the whitened rows (lines, 6, rows * 3) of unit oscillations in single precision.

        That is good enough to find the best of many, and half as much to move.
        """
        local, whitener = self._local.astype(np.float32), self._rows.whitener.astype(np.float32)
        found = np.empty((frequency.size, 6, 3 * len(whitener)), dtype=np.float32)
        for first in range(0, frequency.size, AT_ONCE):
            some = slice(first, first + AT_ONCE)
            H = self._summed(local, frequency[some], felt, np.complex64, False)[0]
            white = whitener @ H.view(np.float32).reshape(len(H), -1)
            found[some] = white.reshape(3 * len(H), -1, 6).transpose(1, 2, 0)
        return found

    def slopes(self, frequency: Array, felt: bool) -> tuple[Array, Array]:
        """Return the whitened rows (rows * 3, lines, 6) of unit oscillations, and their derivatives by f in Hz.

        Columns are x, y, z, of each sine and cosine.
        """
        columns, slopes = self._summed(self._local, frequency, felt, complex, True)
        return self._white(columns), self._white(2 * np.pi * slopes)

    def _white(self, H: Array) -> Array:
        """Return complex (rows, 3, lines, 3) whitened, real parts before imaginary ones: (rows * 3, lines, 6)."""
        count, _, lines, _ = H.shape
        return self._rows.white(H.reshape(count, 3, lines * 3).view(float)).reshape(count * 3, lines, 6)

    def _summed(self, local: Any, frequency: Array, felt: bool, kind: type, slopes: bool) -> list[Any]:
        """Return complex rows (rows, 3, lines, 3) and, on request, their derivatives by 2 pi f."""
        turn, lines = 2 * np.pi * frequency, frequency.size
        near = np.exp(-1j * np.multiply.outer(self._near, turn))
        phase = (1j * np.exp(-1j * np.multiply.outer(self._middle, turn))).astype(kind)[:, None]
        sums = _product(local, near.astype(kind)) * phase  # (rows, 12, lines)
        bare = (self._minus @ near).astype(kind) * phase[:, 0]
        rate: Any = (-1j * turn).astype(kind)
        found = [_assembled(sums[:, :3], sums[:, 3:6], sums[:, 6:], bare, rate, felt)]
        if slopes:
            by = -1j * self._near[:, None] * near
            by_sums = _product(local, by) * phase - 1j * self._middle[:, None, None] * sums
            by_bare = (self._minus @ by) * phase[:, 0] - 1j * self._middle[:, None] * bare
            slope = _assembled(by_sums[:, :3], by_sums[:, 3:6], by_sums[:, 6:], by_bare, rate, felt)
            still = np.zeros_like(sums[:, :6])
            found.append(slope + _assembled(still[:, :3], sums[:, 3:6], still, bare, np.full(lines, -1j), felt))
        return found


def _product(local: Any, near: Any) -> Any:
    """Return complex sums (rows, 12, lines) of local (rows, 12, width) with complex near (width, lines)."""
    count, _, width = local.shape
    both = np.ascontiguousarray(near).view(local.dtype)  # real and imaginary parts, in turn
    return (local.reshape(count * 12, width) @ both).view(near.dtype).reshape(count, 12, near.shape[1])


def _assembled(D: Any, B: Any, C: Any, bare: Any, rate: Any, felt: bool) -> Any:
    """Return -([D +- rate B]x + C - trace C + rate bare) (rows, 3, lines, 3), the last two terms along the diagonal."""
    H = np.empty((D.shape[0], 3, D.shape[2], 3), dtype=D.dtype)
    x, y, z = np.moveaxis(D + (rate if felt else -rate) * B, 1, 0)
    xx, yy, zz, xy, xz, yz = np.moveaxis(C, 1, 0)
    along = rate * bare if felt else np.zeros_like(bare)
    H[:, 0, :, 0], H[:, 1, :, 1], H[:, 2, :, 2] = yy + zz - along, xx + zz - along, xx + yy - along
    H[:, 0, :, 1], H[:, 1, :, 0] = z - xy, -z - xy
    H[:, 2, :, 0], H[:, 0, :, 2] = y - xz, -y - xz
    H[:, 1, :, 2], H[:, 2, :, 1] = x - yz, -x - yz
    return H
