"""The hinge axes below each of a ladder of frequencies, each with how far off it may be."""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.band import quiet_noise, usual_period
from imubench.estimators.carried import Below, Runs, Shared, below, filtered, runs_below, shared
from imubench.estimators.hinge_constraints import Constraints, weigh
from imubench.estimators.hinge_fit import Solution, covariance, descend, spread
from imubench.estimators.olsson2020 import SCREENING, STARTS, W_ACCEL, W_GYRO, algorithm1, distinct, identifiable
from imubench.estimators.spherical import chart
from imubench.estimators.uncertainty import UNBOUNDED
from imubench.paired import Paired
from imubench.recording import Recording

WIDEST = 1.0 / 3.0  # of the rate: the first band below all samples
STEP = 2.0**-0.5  # from band to band: half an octave
PERIODS = 20.0  # of the narrowest band in the recording
LESS_SHARED = 0.1  # of coherence, by which a minimum may fall short of another's
TURNING = 30.0  # times the noise's power, across the axis: noise then takes no more than 0.03 of coherence
REFINED = 4  # minima of the filtered samples that are carried
ROUNDS = 20  # of carrying and descending
STILL = 1e-7  # rad; the carrying ends when the axes move by less
BLOCK = 2.0, 2.0  # s and periods of the band, whichever is longer: errors of different blocks are independent
FEWEST_BLOCKS = 10
CONFIDENCE, CHI_SQUARE = 0.95, 9.488  # and the quantile of chi-square with 4 degrees of freedom
MARGIN = 1.6  # of the noise's power: a std declared within 15 %, and a fifth more of coloured noise, is still noise
COHERENCE = 1.0 / 3.0  # of what is left beyond noise, how much is an error in the shape of each turn of the axes


@dataclass(frozen=True)
class Noise:
    """The noise of both gyroscopes' samples."""

    stds: tuple[float, float]  # rad/s
    declared: bool  # False: those of the quietest second, which may be a hand's or a mount's

    @property
    def variance(self) -> float:
        """That of the difference of two rates' lengths, (rad/s)^2; 0 where none is declared."""
        return self.stds[0] ** 2 + self.stds[1] ** 2 if self.declared else 0.0


@dataclass(frozen=True)
class BandFit:
    """The axes from what both IMUs read below `hz`; None for all of it."""

    hz: float | None
    axes: Array  # (2, 3)
    frames: Array  # (2, 3, 3) rows: axis, dj/dphi, dj/dtheta
    below: Below  # what was fitted, in frames near these
    constraints: Constraints
    solution: Solution  # in the frames of `below`
    random: Array | None  # (4, 4) rad^2 of steps theta1, phi1, theta2, phi2, by blocks of the recording
    coherent: Array | None  # (4, 4) rad^2: what is left beyond noise, were a part of it coherent
    known: bool  # whether the motion shows the axes
    settled: bool  # whether descending and carrying both ended
    turning: bool  # whether the segments turn across the axis by more than noise
    signs_shown: bool  # whether they then share clearly more of it than with one axis reversed
    shared: Shared
    all_shared: Shared  # at the same axes, of all samples
    excess: float  # of the residuals' power that is no noise, 0 to 1
    blocks: int

    @property
    def covariance(self) -> Array | None:
        """The covariance (4, 4) in rad^2 of steps in the chart around the axes; None where the axes are not known."""
        return None if self.random is None or self.coherent is None else self.random + self.coherent

    @property
    def unsure(self) -> float:
        """The root of the covariance's trace, rad."""
        p = self.covariance
        return UNBOUNDED if p is None else float(np.sqrt(np.trace(p)))

    def step_to(self, axes: Array) -> Array:
        """Return the step (4,) in rad, in the chart around these axes, to others (2, 3); a common sign aside."""
        sign = 1.0 if np.sum(axes * self.axes) > 0 else -1.0
        return np.einsum("itk,ik->it", self.frames[:, (2, 1)], sign * axes).ravel()


def ladder(samples: Paired) -> list[float | None]:
    """Return the bands in Hz to be tried, the widest first: all samples, then half an octave at a time."""
    rate, length = 1.0 / usual_period(samples.time), float(samples.time[-1] - samples.time[0])
    bands: list[float | None] = [None]
    hz = WIDEST * rate
    while hz * length > PERIODS:
        bands.append(hz)
        hz *= STEP
    return bands


def band_fit(samples: Paired, hz: float | None, noise: Noise) -> BandFit:
    """Fit the axes below `hz` Hz from every start of section 7.2; `noise` is what the residuals are judged by.

    Algorithm 1 finds the minima of what each sensor read, filtered in its own axes; from the lowest of them the
    rates are carried, fitted and carried again until the axes stay. The lowest cost is taken of those minima in which
    the IMUs share the motion across the axis: with the wrong pairing of signs they turn apart as the hinge turns.
    """
    pieces = runs_below(samples, hz)
    few = filtered(pieces)
    every = slice(None, None, -(-few.time.size // SCREENING))
    rough = weigh(few.gyro1[every], few.gyro2[every], few.accel1[every], few.accel2[every], W_GYRO, W_ACCEL)
    minima = distinct([m for start in STARTS for m in algorithm1(rough, start)])
    found = [_carry(pieces, minimum.x) for minimum in minima[:REFINED]]
    best = min(found, key=lambda one: one.solution.cost)
    across = [shared(pieces, one.turned) for one in found]
    if all(_above_noise(one, pieces, noise) for one in across):
        most = max(one.coherence for one in across)
        agreeing = [one for one, s in zip(found, across, strict=True) if s.coherence > most - LESS_SHARED]
        best = min(agreeing, key=lambda one: one.solution.cost)
    return _judged(pieces, hz, noise, samples, best)


def _above_noise(across: Shared, pieces: Runs, noise: Noise) -> bool:
    """Tell whether the rates across the axis, of two components each, are more than noise; in planar motion not."""
    passed = 1.0 if pieces.low_pass is None else pieces.low_pass.power
    return all(power > TURNING * 2.0 * std**2 * passed for power, std in zip(across.each, noise.stds, strict=True))


@dataclass(frozen=True)
class _Carried:
    """Carried samples with their minimum, and the frames (2, 3, 3) that both are in."""

    below: Below
    constraints: Constraints
    solution: Solution
    frames: Array
    settled: bool

    @property
    def turned(self) -> Array:
        """The frames (2, 3, 3) of the minimum itself."""
        return np.asarray(self.solution.frames[:, (0, 2, 1)] @ self.frames)


def _carry(pieces: Runs, start: Array) -> _Carried:
    """Carry the rates about axes `start` (4,), fit, and carry again about what was found, until the axes stay."""
    frames, rounds = chart(start)[:, (0, 2, 1)], 0
    while True:
        carried = below(pieces, frames)
        c = carried.weighed(W_GYRO, W_ACCEL)
        s = descend(c, np.zeros(4))
        still = float(np.linalg.norm(s.axes[:, 1:], axis=1).max()) < STILL
        rounds += 1
        if still or rounds == ROUNDS:
            return _Carried(carried, c, s, frames, still and s.converged)
        frames = s.frames[:, (0, 2, 1)] @ frames


def _judged(pieces: Runs, hz: float | None, noise: Noise, samples: Paired, found: _Carried) -> BandFit:
    c, s = found.constraints, found.solution
    frames = found.turned
    passed = 1.0 if pieces.low_pass is None else pieces.low_pass.power
    expected = MARGIN * noise.variance * passed
    excess = max(0.0, 1.0 - expected / max((s.gyro_std / W_GYRO) ** 2, 1e-300))
    random, blocks = block_spread(found.below, c, s, hz)
    white = covariance(c, s)
    across = shared(pieces, frames)
    turning = _above_noise(across, pieces, noise)
    reversed_axis = frames * np.array([np.ones(3), [-1.0, 1.0, -1.0]])[:, :, None]  # of imu2
    return BandFit(
        hz=hz,
        axes=frames[:, 0],
        frames=frames,
        below=found.below,
        constraints=c,
        solution=s,
        random=random,
        coherent=None if white is None else COHERENCE**2 * excess * c.gyro_count * white,
        turning=turning,
        signs_shown=turning and across.coherence > shared(pieces, reversed_axis).coherence + LESS_SHARED,
        known=identifiable(c, s),
        settled=found.settled,
        shared=across,
        all_shared=shared(runs_below(samples, None), frames),
        excess=excess,
        blocks=blocks,
    )


def block_spread(carried: Below, c: Constraints, s: Solution, hz: float | None) -> tuple[Array | None, int]:
    """Return the covariance (4, 4) in rad^2 of the axes by the scatter of blocks of the recording, and their number.

    The sandwich H^-1 S H^-1 with S from the sums of the gradient over blocks longer than errors stay alike: filtered
    samples are correlated within them as they like. It is widened so that the 95 % region of a normal distribution
    with this covariance is Hotelling's for so many blocks.
    """
    from scipy.stats import f as fisher  # here: long to import, and most commands do without

    since = carried.time - carried.time[0]
    block = max(BLOCK[0], BLOCK[1] / hz if hz else 0.0)
    block = min(block, float(since[-1]) / FEWEST_BLOCKS)
    number = np.unique((since / max(block, 1e-9)).astype(int), return_inverse=True)[1]
    count = int(number[-1]) + 1
    if count < 6:  # fewer leave no degree of freedom for four directions
        return None, count
    sums = np.zeros((count, 4))
    np.add.at(sums, number, _gradients(carried, s))
    scores = sums.T @ sums * count / (count - 1)
    hotelling = 4 * (count - 1) / (count - 4) * float(fisher.ppf(CONFIDENCE, 4, count - 4)) / CHI_SQUARE
    return spread(c, s, hotelling * scores), count


def _gradients(carried: Below, s: Solution) -> Array:
    """Return the gradient (n, 4) of half the cost by theta1, phi1, theta2, phi2, for each sample."""
    rates = [W_GYRO * w @ frame.T for w, frame in zip(carried.rates, s.frames, strict=True)]
    forces = [W_ACCEL * f @ frame.T for f, frame in zip(carried.forces, s.frames, strict=True)]
    lengths = [np.hypot(w[:, 1], w[:, 2]) + 1e-300 for w in rates]
    slopes = [w[:, 1:] * (w[:, :1] / length[:, None]) for w, length in zip(rates, lengths, strict=True)]
    gyro = np.hstack([-slopes[0], slopes[1]]) * (lengths[0] - lengths[1])[:, None]
    accel = np.hstack([forces[0][:, 1:], -forces[1][:, 1:]]) * (forces[0][:, 0] - forces[1][:, 0])[:, None]
    return gyro + accel


def gyro_noise(recording: Recording) -> Noise:
    """Return the noise of both gyroscopes: as declared, or, unless both are, that of the quietest second."""
    imus = [recording.imu(name) for name in ("imu1", "imu2")]
    first, second = (quiet_noise(i.gyro, i.rate, 0.0) if i.gyro_noise_std is None else i.gyro_noise_std for i in imus)
    return Noise((first, second), all(i.gyro_noise_std is not None for i in imus))
