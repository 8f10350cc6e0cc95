"""The plug-and-play hinge axis of Olsson et al., Sensors 20 (2020) 3534: Algorithms 1 to 4 on a stream.

stream = PlugAndPlay(Settings())
update = stream.update(batch)          # a second of samples
if update.accepted: use(update.estimate.value)
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.estimate import Estimate, Pairing
from imubench.estimators import selection
from imubench.estimators.hinge_constraints import Constraints, weigh
from imubench.estimators.hinge_fit import Solution, covariance
from imubench.estimators.olsson2020 import W0, algorithm1
from imubench.estimators.pairing import paired_axes, told_by_data
from imubench.estimators.selection import Selected
from imubench.estimators.selection_accel import ENERGY_THRESHOLD
from imubench.estimators.selection_gyro import HALF_WIDTH
from imubench.estimators.selection_online import OnlineSelection
from imubench.estimators.uncertainty import (
    Acceptance,
    Verdict,
    local_uncertainty,
    of_axes,
    paper_covariance,
    two_sigma,
)
from imubench.paired import Paired, paired
from imubench.recording import Recording, positive

NAME = "olsson2020-plug-and-play"
NO_MINIMUM = "the cost has no minimum there: in some direction the axes can move and it does not rise"
BATCH = 1.0  # s, section 7.3
WINDOW_RATE = 50.0  # Hz, at which the paper's windows are counted in samples


@dataclass(frozen=True)
class Settings:
    """What the user of Algorithms 1 to 4 chooses; the defaults are those of sections 7.3 and 7.4.

    Raises `InputError` for what cannot be.
    """

    n_max: int = 1000  # samples of either kind to keep at most
    half_width: int = HALF_WIDTH  # samples, n of the windows of 2 n + 1; 0.2 s at 50 Hz
    threshold: float = ENERGY_THRESHOLD  # E_th, rad^2/s^2
    w0: float = W0  # w_gyro / w_accel
    e_max: float = math.radians(3.0)  # E_max, rad
    n_min: int = 10  # consecutive estimates that must agree
    draws: int = 1000  # L of the Monte Carlo method; the paper gives no value
    form: str = "printed"  # of Algorithm 3
    memory: str = "survivors"  # of the online selection

    def __post_init__(self) -> None:
        """Check every parameter; those of the selection by its own rules."""
        selection.Settings(self.n_max, self.half_width, self.threshold, self.form)
        for name in ("w0", "e_max"):
            positive(getattr(self, name), name)
        for name, least in (("n_min", 1), ("draws", 2)):
            if getattr(self, name) < least:
                raise InputError(f"{name}: expected at least {least}, got {getattr(self, name)}")

    @property
    def weights(self) -> tuple[float, float]:
        """The weights of gyroscope and accelerometer residuals, eq. (70)."""
        return math.sqrt(self.w0), 1.0 / math.sqrt(self.w0)


@dataclass(frozen=True)
class Fit:
    """What an estimate was made from: the selected samples and the minima of both sign pairings."""

    samples: Selected
    constraints: Constraints
    best: Solution
    other: Solution


@dataclass(frozen=True)
class Update:
    """The answer to one batch."""

    estimate: Estimate  # from all data so far; its signs follow the estimate before, eq. (66)
    accepted: bool
    why: str  # what is still missing; empty once accepted
    verdict: Verdict  # the figures of Algorithm 4
    fit: Fit = field(repr=False)


class PlugAndPlay:
    """The hinge axes from samples as they arrive; every update starts the solver at random, as the paper does.

    After the first accepted estimate, where Algorithm 4 ends, updates go on in the same way.
    """

    def __init__(self, settings: Settings | None = None, rng: np.random.Generator | None = None):
        self.settings = s = Settings() if settings is None else settings
        self._selection = OnlineSelection(s.n_max, s.half_width, s.threshold, s.form, s.memory)
        self._starts, self._draws = (np.random.default_rng(0) if rng is None else rng).spawn(2)
        self._acceptance = Acceptance(s.e_max, s.n_min)

    def update(self, batch: Paired) -> Update:
        """Take the next samples, estimate anew from all that are worth keeping, and judge the estimate."""
        chosen = self._selection.update(batch.gyro1, batch.gyro2, batch.accel1, batch.accel2)
        c = weigh(chosen.gyro1, chosen.gyro2, chosen.accel1, chosen.accel2, *self.settings.weights)
        best, other = algorithm1(c, uniform_start(self._starts))
        local = local_uncertainty(paper_covariance(best), self._draws, self.settings.draws)
        verdict = self._acceptance.update(best.axes, local)
        fit = Fit(chosen, c, best, other)
        return Update(self._estimate(fit, verdict), verdict.accepted, self._missing(verdict), verdict, fit)

    def _estimate(self, fit: Fit, verdict: Verdict) -> Estimate:
        """Return the estimate with the figures that led to the verdict, and the honest ones beside them."""
        weights, best = self.settings.weights, fit.best
        details = {
            "cost": best.cost,
            "cost_other_pairing": fit.other.cost,
            "iterations": float(best.iterations + fit.other.iterations),
            "gyro_samples": float(fit.constraints.gyro_count),
            "accel_samples": float(fit.constraints.accel_count),
            "seqad": verdict.seqad,  # rad
            "worst_seqad": verdict.worst_seqad,
            "gyro_residual_std": best.gyro_std / weights[0],  # rad/s
            "accel_residual_std": best.accel_std / weights[1],  # m/s^2
        }
        details |= {f"local_uncertainty_{i + 1}": float(verdict.local[i]) for i in range(2)}  # rad, eq. (57)
        if not verdict.accepted:
            why = self._missing(verdict)
            return Estimate(
                "joint_axis", NAME, verdict.axes, None, why, "not identifiable", details=details, pairing="unknown"
            )
        told = told_by_data(fit.samples.accel1, fit.samples.accel2, verdict.axes)
        pairing: Pairing = "from data" if told else "unknown"
        spread = covariance(fit.constraints, best)
        if spread is None:
            return Estimate("joint_axis", NAME, verdict.axes, None, NO_MINIMUM, details=details, pairing=pairing)
        details |= {f"honest_uncertainty_{i + 1}": float(u) for i, u in enumerate(two_sigma(spread))}
        spread = of_axes(spread, best, verdict.axes)
        return Estimate("joint_axis", NAME, verdict.axes, spread, details=details, pairing=pairing)

    def _missing(self, verdict: Verdict) -> str:
        if verdict.accepted:
            return ""
        limit, worst = math.degrees(self.settings.e_max), math.degrees(verdict.local.max())
        reasons = []
        if not worst < limit:
            reasons.append(f"an axis may move by {worst:.1f} deg in some direction (mu + 2 sigma)")
        if not verdict.worst_seqad < self.settings.e_max:
            moved = math.degrees(verdict.worst_seqad)
            reasons.append(f"the last {self.settings.n_min} estimates moved by up to {moved:.1f} deg in some direction")
        return f"{' and '.join(reasons)}; {limit:g} deg allowed"


def uniform_start(rng: np.random.Generator) -> Array:
    """Return a start (4,) in rad, uniform over theta in +-pi/2 and phi in +-pi: the parameter space of eq. (20)."""
    return np.asarray(rng.uniform(-1.0, 1.0, size=4) * np.array([0.5, 1.0, 0.5, 1.0]) * np.pi)


def batches(samples: Paired, seconds: float = BATCH) -> Iterator[Paired]:
    """Cut samples into pieces of `seconds` s from the first sample on; empty ones are left out."""
    number = np.floor((samples.time - samples.time[0]) / seconds + 1e-6).astype(int)
    edges = [0, *(np.flatnonzero(np.diff(number)) + 1), number.size]
    for first, last in pairwise(edges):
        columns = (getattr(samples, key)[first:last] for key in ("time", "gyro1", "accel1", "gyro2", "accel2"))
        yield Paired(*columns)


def estimate(recording: Recording, settings: Settings | None = None, seed: int = 0) -> Estimate:
    """Feed a recording to `PlugAndPlay` second by second and return the first accepted estimate.

    Without one: the last estimate, `not identifiable`, and why. The windows keep their length of 0.42 s at any
    rate unless settings are given. The common sign points along +y of the segments, by the declared mounts.
    Raises `InputError` with fewer than two IMUs.
    """
    samples = paired(recording)
    settings = at_rate(samples) if settings is None else settings
    stream = PlugAndPlay(settings, np.random.default_rng(seed))
    return first_accepted(recording, samples, stream.update)


def at_rate(samples: Paired) -> Settings:
    """Return the default settings with windows as long, in s, as the paper's at 50 Hz."""
    period = float(np.median(np.diff(samples.time))) if samples.time.size > 1 else 1.0 / WINDOW_RATE
    return Settings(half_width=round(HALF_WIDTH / (WINDOW_RATE * period)))


def first_accepted(
    recording: Recording,
    samples: Paired,
    update: Callable[[Paired], Update],
) -> Estimate:
    """Return the first accepted estimate of a stream, or the last one; `details` says after how many seconds.

    Where the selected samples do not tell how the signs go together, the declared mounts do, if any.
    """
    for batch in batches(samples):
        last = update(batch)
        if last.accepted:
            break
    found = last.estimate
    details = {**found.details, "seconds": float(batch.time[-1] - samples.time[0])}
    axes, pairing = paired_axes(recording, found.value, last.fit.samples.accel1, last.fit.samples.accel2)
    spread = found.covariance
    if spread is not None:
        signs = np.repeat(np.sign(np.sum(axes * found.value, axis=1)), 3)
        spread = spread * np.outer(signs, signs)
    return replace(
        found, value=axes, covariance=spread, details=details, pairing=pairing if last.accepted else "unknown"
    )
