"""The hinge's constraints below a frequency, both IMUs' rates carried into one frame before the filter.

Across the axis segment 2 turns as segment 1 does, seen in a frame that the hinge has turned by its angle q. A filter
over each sensor's own samples mixes directions that q has meanwhile turned, and a rigid hinge does not obey the
constraint of Olsson 2020, eq. (24), any more. Turned back by q, which the gyroscopes themselves tell, it does: the
filter is linear, and both sides of it are one signal. docs/band.md has the equations.
"""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.band import EVEN, LowPass, runs, usual_period
from imubench.errors import InputError
from imubench.estimators.hinge_constraints import Constraints, weigh
from imubench.paired import Paired

PER_PERIOD = 6  # samples kept of a period of the band: at three times the band nothing is left to fold
WINDOW = 2.0  # s over which the rates of both sensors are compared: drifts of q by a gyroscope's bias are slower


@dataclass(frozen=True)
class Runs:
    """Even, unbroken runs of samples of both IMUs, each with what filters it; None for the samples as they are."""

    pieces: tuple[Paired, ...]
    low_pass: LowPass | None


@dataclass(frozen=True)
class Below:
    """Samples of a pair of IMUs below a frequency at some axes: what `weigh` takes, in the frames of these axes."""

    time: Array  # (n,) s
    rates: Array  # (2, n, 3) rad/s, along the axis and across it
    forces: Array  # (2, n, 3) m/s^2

    def weighed(self, w_gyro: float, w_accel: float) -> Constraints:
        """Return both constraints with these weights, ready to be evaluated."""
        return weigh(self.rates[0], self.rates[1], self.forces[0], self.forces[1], w_gyro, w_accel)


@dataclass(frozen=True)
class Shared:
    """The mean power in rad^2/s^2 of the rates across the axis: of what both IMUs share, and of each alone."""

    both: float
    each: tuple[float, float]

    @property
    def coherence(self) -> float:
        """The part of the motion across the axis that both IMUs share, 0 to 1."""
        return self.both / max(np.sqrt(self.each[0] * self.each[1]), 1e-300)


def runs_below(samples: Paired, hz: float | None) -> Runs:
    """Cut samples into even runs that are long enough for the band; `InputError` if none is."""
    period = usual_period(samples.time)
    low_pass = None if hz is None else LowPass(hz, period)
    fewest = 2 if low_pass is None else low_pass.shortest
    pieces = [_even(samples, run, period) for run in runs(samples.time, period) if run.stop - run.start >= fewest]
    if not pieces:
        longest = max(samples.time[run][-1] - samples.time[run][0] for run in runs(samples.time, period))
        raise InputError(f"expected {fewest * period:.3g} s of both IMUs without a gap, got at most {longest:.3g} s")
    return Runs(tuple(pieces), low_pass)


def _even(samples: Paired, run: slice, period: float) -> Paired:
    time = samples.time[run]
    grid = np.linspace(time[0], time[-1], round((time[-1] - time[0]) / period) + 1)
    columns = {key: getattr(samples, key)[run] for key in ("gyro1", "accel1", "gyro2", "accel2")}
    if grid.size != time.size or np.abs(grid - time).max() > EVEN * period:
        columns = {k: np.stack([np.interp(grid, time, x) for x in v.T], axis=1) for k, v in columns.items()}
        time = grid
    return Paired(time, **columns)


def filtered(pieces: Runs) -> Paired:
    """Return the samples of both IMUs below the band, each filtered in its own axes, a few to a period."""
    one = pieces.low_pass
    time = [p.time if one is None else _kept(p.time, one) for p in pieces.pieces]
    columns = (
        [x if one is None else _thinned(x, one) for x in (getattr(p, key) for p in pieces.pieces)]
        for key in ("gyro1", "accel1", "gyro2", "accel2")
    )
    return Paired(np.concatenate(time), *(np.concatenate(column) for column in columns))


def below(pieces: Runs, frames: Array) -> Below:
    """Return the samples below the band, carried by the hinge's angle about the axes in frames (2, 3, 3).

    The rows of a frame are the axis and two directions across it, right-handed. Turning an axis by a small angle
    changes the carried rates as it changes rates that are not carried, with the length of `rates[1, :, 0]` along it.
    """
    parts = [_below(piece, pieces.low_pass, frames) for piece in pieces.pieces]
    time, rates, forces = zip(*parts, strict=True)
    return Below(np.concatenate(time), np.concatenate(rates, axis=1), np.concatenate(forces, axis=1))


def _below(piece: Paired, low_pass: LowPass | None, frames: Array) -> tuple[Array, Array, Array]:
    forces = np.stack([piece.accel1 @ frames[0].T, piece.accel2 @ frames[1].T])
    if low_pass is None:
        return piece.time, np.stack([piece.gyro1 @ frames[0].T, piece.gyro2 @ frames[1].T]), forces
    along1, across1, along2, across2 = _thinned(_carried(piece, frames), low_pass).T
    size = np.abs(along2)  # the slope of across2 by a step of axis 2 is -along2: turn both so that it is real
    across2 = across2 * np.where(size > 0, along2.conj() / np.where(size > 0, size, 1.0), 1.0)
    rates = [
        np.stack([along, across.real, across.imag], axis=1)
        for along, across in ((along1.real, across1), (size, across2))
    ]
    return _kept(piece.time, low_pass), np.stack(rates), np.stack([_thinned(f, low_pass) for f in forces])


def _carried(piece: Paired, frames: Array) -> Array:
    """Return rates (n, 4): along and across axis 1, along and across axis 2, turned back by the hinge's angle.

    Complex: what is across has two parts, and what is turned back is turned in that plane.
    """
    w1, w2 = piece.gyro1 @ frames[0].T, piece.gyro2 @ frames[1].T
    speed = w2[:, 0] - w1[:, 0]
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(piece.time))])
    back = np.exp(1j * angle)
    return np.stack(
        [w1[:, 0] + 0j, w1[:, 1] + 1j * w1[:, 2], w2[:, 0] * back, (w2[:, 1] + 1j * w2[:, 2]) * back], axis=1
    )


def _thinned(columns: Array, low_pass: LowPass) -> Array:
    return low_pass.apply(columns)[:: _every(low_pass)]


def _kept(time: Array, low_pass: LowPass) -> Array:
    lost = low_pass.lost()
    return time[lost : len(time) - lost : _every(low_pass)]


def _every(low_pass: LowPass) -> int:
    return max(1, int(1.0 / (PER_PERIOD * low_pass.hz * low_pass.period)))


def shared(pieces: Runs, frames: Array) -> Shared:
    """Return the power of the rates across the axes in frames (2, 3, 3) that both IMUs share below the band.

    The hinge's angle is known up to a constant and a slow drift: the phase between the two is that of each window.
    """
    both, each, count = 0.0, np.zeros(2), 0
    for piece in pieces.pieces:
        across = _carried(piece, frames)[:, 1::2]
        if pieces.low_pass is not None:
            across = pieces.low_pass.apply(across)
        step = max(1, round(WINDOW / float(piece.time[1] - piece.time[0])))
        cross = np.add.reduceat(across[:, 0] * across[:, 1].conj(), np.arange(0, len(across), step))
        both += float(np.abs(cross).sum())
        each += np.sum(np.abs(across) ** 2, axis=0)
        count += len(across)
    return Shared(both / count, (float(each[0]) / count, float(each[1]) / count))
