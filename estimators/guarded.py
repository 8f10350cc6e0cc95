"""A guard for Algorithm 4 of Olsson 2020: an estimate is accepted only if errors that are not white noise fit in too.

Algorithm 4 takes the residuals for white noise, whose effect vanishes with the number of samples. What soft mounts,
sensor biases, joint play and lever arms do does not. The guard asks four questions of an estimate that Algorithm 4
accepts, each with its own figure, and none of them knows what the error is: docs/plug-and-play.md.
"""

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.estimate import Estimate, Status
from imubench.estimators import banded
from imubench.estimators.hinge_constraints import Constraints, weigh
from imubench.estimators.hinge_fit import Solution, descend, spread
from imubench.estimators.olsson2020 import SAME, STARTS, algorithm1, deviation, distinct
from imubench.estimators.plug_and_play import (
    Fit,
    PlugAndPlay,
    Settings,
    Update,
    at_rate,
    first_accepted,
)
from imubench.estimators.selection import Selected
from imubench.estimators.spherical import opposite
from imubench.estimators.uncertainty import UNBOUNDED, two_sigma
from imubench.paired import Paired, paired
from imubench.recording import Recording, positive

NAME = "olsson2020-guarded"
ENOUGH = 1e-6  # of the cost: where descents that only measure a spread end; its last digits do not matter
POSTURE = 0.25  # rad; an error that follows the direction of gravity changes by a quarter of its size


@dataclass(frozen=True)
class Guard:
    """How large errors may be that the residuals do not show, and how sure the guard has to be.

    Each number is argued in docs/plug-and-play.md; none was fitted to recordings.
    """

    gyro_bias_std: float = math.radians(0.5) / math.sqrt(3.0)  # rad/s an axis; |b| of 0.5 deg/s, section 9.4
    accel_bias_std: float = 0.1 / math.sqrt(3.0)  # m/s^2 an axis; |b| of 0.1 m/s^2, section 9.4
    coherence: float = 0.5  # of the residual, how much could have passed for a turn of the axes
    groups: int = 10  # pieces of time that the samples are cut into

    def __post_init__(self) -> None:
        """Check every parameter."""
        for name in ("gyro_bias_std", "accel_bias_std", "coherence"):
            positive(getattr(self, name), name, or_zero=True)
        positive(self.groups - 1, "groups - 1")


class GuardedPlugAndPlay:
    """`PlugAndPlay` behind a `Guard`: the same updates, but some that it accepts are not."""

    def __init__(
        self,
        settings: Settings | None = None,
        rng: np.random.Generator | None = None,
        guard: Guard | None = None,
    ):
        self._stream, self.guard = PlugAndPlay(settings, rng), Guard() if guard is None else guard
        self._found: deque[Solution] = deque(maxlen=2 * self.settings.n_min)

    @property
    def settings(self) -> Settings:
        """The settings of the stream."""
        return self._stream.settings

    def update(self, batch: Paired) -> Update:
        """Take the next samples as `PlugAndPlay.update` does; question what it accepts."""
        update = self._stream.update(batch)
        self._found += (update.fit.best, update.fit.other)
        found = replace(update.estimate, estimator=NAME)
        if not update.accepted:
            return replace(update, estimate=found)
        figures, why = question(update.fit, list(self._found), self.settings, self.guard)
        details = {**found.details, **figures}
        if not why:
            return replace(update, estimate=replace(found, details=details))
        refused = Estimate(
            "joint_axis", NAME, found.value, None, why, "not identifiable", details=details, pairing="unknown"
        )
        return replace(update, estimate=refused, accepted=False, why=why)


def question(fit: Fit, found: list[Solution], settings: Settings, guard: Guard) -> tuple[dict[str, float], str]:
    """Return the guard's figures and what speaks against the estimate; empty if nothing does.

    `found` are the minima that the random starts of the last updates led to, of the data they then had. The
    questions come by rising cost, and the first objection ends them.
    """
    figures: dict[str, float] = {}

    def turns(name: str, bound: float, what: str) -> str:
        figures[name] = bound  # rad
        off, limit = math.degrees(bound), math.degrees(settings.e_max)
        return "" if bound < settings.e_max else f"{what} {off:.1f} deg in some direction; {limit:g} deg allowed"

    by_residual = guard.coherence * coherent_error(fit).max()
    why = turns("residual_bound", float(by_residual), "what the hinge leaves unexplained could turn an axis by")
    if why:
        return figures, why
    by_bias = bias_spread(fit, settings, guard)
    why = turns("bias_bound", float(two_sigma(by_bias).max()), "sensor biases could turn an axis by")
    if why:
        return figures, why
    by_pieces = jackknife_spread(fit, settings, guard.groups) + by_bias
    why = turns("pieces_bound", float(two_sigma(by_pieces).max()), "pieces of the recording leave an axis open by")
    if why:
        return figures, why
    figures["rival_coherence"] = needed = rival_coherence(fit, found)
    if needed > guard.coherence:
        return figures, ""
    return figures, (
        f"another minimum, in another direction, is right if errors have coherence {needed:.2f}; "
        f"up to {guard.coherence:g} is taken as possible"
    )


def coherent_error(fit: Fit) -> Array:
    """Return by how much (2,) in rad an error as large as the residuals could turn either axis, at worst.

    For each kind of residual e_c, with sum of squares |e_c|^2, and any error of that size: dx = H^-1 J_c^T e,
    within H^-1 J_c^T J_c H^-1 |e_c|^2. That is the covariance of white noise, were all samples one.
    """
    s, c = fit.best, fit.constraints
    gyro, accel = (float(e @ e) for e in residuals(c, s.axes))
    worst = spread(c, s, gyro * s.gyro_information + accel * s.accel_information)
    if worst is None:
        return np.full(2, UNBOUNDED)
    return np.sqrt(np.linalg.eigvalsh(np.stack([worst[:2, :2], worst[2:, 2:]]))[:, -1])


def bias_spread(fit: Fit, settings: Settings, guard: Guard) -> Array:
    """Return the covariance (4, 4) in rad^2 of the axes that unknown constant biases of the sensors make.

    To first order dx = -H^-1 J^T (de/db) b. Of a gyroscope residual w |w x j|: de/db is the unit vector of w
    across j; of an accelerometer residual it is j.
    """
    w_gyro, w_accel = settings.weights
    influence = np.zeros((4, 12))
    rates, forces = (fit.samples.gyro1, fit.samples.gyro2), (fit.samples.accel1, -fit.samples.accel2)
    gyro_rows, accel_rows, units = [], [], []
    for w, f, frame, sign in zip(rates, forces, fit.best.frames, (1.0, -1.0), strict=True):
        parts = w @ frame.T
        across = np.hypot(parts[:, 1], parts[:, 2]) + 1e-300
        unit = (parts[:, 1:] / across[:, None]) @ frame[1:]
        units.append(sign * w_gyro * unit)
        gyro_rows.append(-sign * w_gyro * parts[:, :1] * parts[:, 1:] / across[:, None])
        accel_rows.append(w_accel * f @ frame[1:].T)
    influence[:, :6] = guard.gyro_bias_std * np.hstack(gyro_rows).T @ np.hstack(units)
    total = np.hstack(accel_rows).sum(axis=0)
    axes = np.concatenate([fit.best.axes[0], -fit.best.axes[1]])
    influence[:, 6:] = guard.accel_bias_std * w_accel * np.outer(total, axes)
    found = spread(fit.constraints, fit.best, influence @ influence.T)
    return np.eye(4) * UNBOUNDED**2 if found is None else found


def jackknife_spread(fit: Fit, settings: Settings, groups: int) -> Array:
    """Return the covariance (4, 4) in rad^2 of the axes by leaving out one of `groups` pieces of time after the other.

    The delete-a-group jackknife about the full estimate; within a piece, errors may be correlated as they like.
    """
    s, best = fit.samples, fit.best
    accel = postures(np.hstack([s.accel1, s.accel2]))
    groups = max(2, min(groups, accel[-1] + 1 if accel.size else groups))
    gyro = np.arange(len(s.gyro1)) * groups // max(len(s.gyro1), 1)
    accel = accel * groups // (accel[-1] + 1 if accel.size else 1)
    off = np.empty((groups, 4))
    for g in range(groups):
        u, v = gyro != g, accel != g
        rest = weigh(s.gyro1[u], s.gyro2[u], s.accel1[v], s.accel2[v], *settings.weights)
        off[g] = np.einsum("itk,ik->it", best.tangents, descend(rest, best.x, ENOUGH).axes).ravel()
    return np.asarray((groups - 1) / groups * off.T @ off)


def postures(rows: Array) -> NDArray[np.intp]:
    """Number the postures (m,) that samples (m, 6) of specific force were taken in, in the order of time.

    A new one begins when the direction of the row is POSTURE away from where the last one began. What a mount does
    under gravity is the same for as long as the posture is: all its samples are one observation.
    """
    unit = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    number, first, count = np.zeros(len(unit), dtype=np.intp), 0, 0
    while first < len(unit):
        left = unit[first:] @ unit[first] < math.cos(POSTURE)
        begin = first + int(left.argmax()) if left.any() else len(unit)
        number[first:begin] = count
        first, count = begin, count + 1
    return number


def rival_coherence(fit: Fit, found: list[Solution]) -> float:
    """Return how coherent the errors would have to be if the truth lay in any other minimum than the best.

    Residuals e2 of a rival and e1 of the best, of one kind of sensor, differ by D = e2 - e1. If the rival is true, e2
    is all error, and its part along D, to its part across D, is what this returns: of the kind of sensor that
    speaks louder against it, for the most credible rival. 0 if a rival's cost is lower than the best one's.
    """
    minima = [descend(fit.constraints, s.x, ENOUGH) for s in distinct([*found, fit.other])]
    rivals = [s for s in distinct(minima) if deviation(s.axes, fit.best.axes) > SAME]
    if any(s.cost < (1.0 - ENOUGH) * fit.best.cost for s in rivals):
        return 0.0
    mine = residuals(fit.constraints, fit.best.axes)
    needed = [
        max(_along_to_across(e2, e2 - e1) for e1, e2 in zip(mine, residuals(fit.constraints, s.axes), strict=True))
        for s in rivals
    ]
    return min(needed, default=math.inf)


def residuals(c: Constraints, axes: Array) -> tuple[Array, Array]:
    """Return the weighted residuals of gyroscopes and, rotated among each other, of accelerometers at axes (2, 3)."""
    off_axis = np.linalg.norm(np.cross(c.rates, axes[None, :, :, None], axisa=2, axisb=2, axisc=2), axis=2)
    return (off_axis[:, 0] - off_axis[:, 1]).ravel(), np.einsum("ikj,ij->k", c.forces, axes)


def _along_to_across(error: Array, direction: Array) -> float:
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        return 0.0
    along = float(error @ direction) / length
    across = math.sqrt(max(float(error @ error) - along * along, 0.0))
    return along / max(across, 1e-300)


def estimate(
    recording: Recording, settings: Settings | None = None, guard: Guard | None = None, seed: int = 0
) -> Estimate:
    """Feed a recording to `GuardedPlugAndPlay` second by second, as `plug_and_play.estimate` does.

    Where nothing is accepted, the axes below a band that the data choose are offered instead (`banded`), labelled so:
    `offered_instead` in `details`. They are `converged` only if the guard's four questions leave no objection.
    """
    samples = paired(recording)
    settings = at_rate(samples) if settings is None else settings
    stream = GuardedPlugAndPlay(settings, np.random.default_rng(seed), guard)
    found = first_accepted(recording, samples, stream.update)
    return found if found.status == "converged" else _instead(recording, found, settings, stream.guard)


def _instead(recording: Recording, refused: Estimate, settings: Settings, guard: Guard) -> Estimate:
    """Return the banded estimate of a recording of which nothing was accepted; the refusal if it shows no axes."""
    chosen, fits = banded.chosen_fit(recording)
    answer = banded.answer(recording, chosen, fits)
    if answer.covariance is None:
        return refused
    c = chosen.below.weighed(*settings.weights)
    minima = [m for start in STARTS for m in algorithm1(c, start, ENOUGH)]
    best = descend(c, chosen.solution.x, ENOUGH)
    every = np.arange(chosen.below.time.size)
    samples = Selected(every, every, *chosen.below.rates, *chosen.below.forces)
    fit = Fit(samples, c, best, descend(c, opposite(best.x), ENOUGH))
    figures, why = question(fit, minima, settings, guard)
    status: Status = answer.status if not why else "not converged"
    kept = {key: refused.details[key] for key in ("seconds", "seqad", "worst_seqad") if key in refused.details}
    details = {**answer.details, **kept, **figures, banded.OFFERED: 1.0}
    return replace(answer, estimator=NAME, status=status, details=details)
