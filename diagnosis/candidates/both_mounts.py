"""Mounts that give way at both ends of a hinge: geometry from the slow band, then the springs of both IMUs at once.

Springs that both IMUs are on look like noise, and one sprung mount at a time takes in what both do: the other's motion
goes into the geometry, which turns by tens of degrees and fits. Below some frequency both IMUs obey the hinge
(`olsson2020-banded` finds it). The rigid model of what is left there has the mounts; held to these, the springs of both
are fitted while the noise is still what the rigid model left, and the noise then falls to what they leave. Only then
are the mounts free again. All the while the hinge is held as smooth as the segments that it joins.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench.band import banded
from imubench.diagnosis.config.candidates import GIVING_WAY
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.noise import KNOT_SELECTION, REML
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.criteria.effect_dynamics import driven_by_motion
from imubench.diagnosis.noise.looser_motion import TURNING_ROUGHNESS
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import fit_with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.rig_kinematics import HINGE
from imubench.diagnosis.samples.rest_noise import MOST_REST_STD
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.subset import excerpt, loudest
from imubench.effects import EFFECTS
from imubench.errors import InputError
from imubench.estimators.banded import chosen_fit
from imubench.recording import Imu, Recording


def gives_way(fit: Fit) -> bool:
    """Return whether both IMUs are on springs and what these leave is still more than any gyroscope's noise.

    Then something of the mounts is not as straight springs are, and nobody knows how large: a further effect would be
    judged by noise that is none.
    """
    sprung = {h.at for h in fit.model.hypotheses if h.effect.on_springs}
    return len(sprung) == 2 and louder_than_any(fit)


def louder_than_any(fit: Fit) -> bool:
    """Return whether two gyroscopes leave more than any gyroscope's noise, whatever is declared.

    Their power together: of two that do not agree about one motion, either may get all of what they differ by.
    """
    return len(fit.model.recording.imus) == 2 and gyro_power(fit) > 2 * MOST_REST_STD["gyro"] ** 2


def gyro_power(fit: Fit) -> float:
    """Return the summed variances of all gyroscopes' noise, (rad/s)^2."""
    return float(sum(fit.noise[f"{imu.name}.gyro"] ** 2 for imu in fit.model.recording.imus))


def left_power(fit: Fit) -> float:
    """Return the mean squared residual of all gyroscopes, (rad/s)^2, whatever the noise was taken for."""
    gyros = [r.residual.value for r in fit.measured if r.name.endswith(".gyro")]
    return float(sum(np.mean(x**2) for x in gyros))


def agreeing_band(recording: Recording) -> float | None:
    """Return the frequency in Hz below which both IMUs obey the hinge; None where all samples do, or none."""
    try:
        return chosen_fit(recording)[0].hz
    except InputError:
        return None


def slow_recording(recording: Recording, hz: float) -> Recording:
    """Return what both IMUs read below a frequency, as few samples as it needs, no noise declared."""

    def thinned(imu: Imu) -> Imu:
        every = max(1, int(imu.rate / (KNOT_SELECTION.knots_per_period * hz)))
        few = slice(None, None, every)
        return replace(
            imu,
            time=imu.time[few],
            gyro=imu.gyro[few],
            accel=imu.accel[few],
            rate=imu.rate / every,
            gyro_noise_std=None,
            accel_noise_std=None,
        )

    slow = banded(recording, hz)
    return replace(slow, imus=tuple(thinned(imu) for imu in slow.imus))


def on_springs(fit: Fit) -> Fit | None:
    """Return a fit whose IMUs are both on rocking springs, begun from the geometry of the band in which they agree.

    None where they agree in none, where something is on springs already, or where the first steps of the springs leave
    too much.
    """
    recording = fit.model.recording
    if any(h.effect.on_springs for h in fit.model.hypotheses):
        return None
    hz = agreeing_band(recording)
    if hz is None:
        return None
    slow = nominal_fit(slow_recording(recording, hz))
    held = {n: v for n, v in slow.state.values.items() if n.endswith((".rotation", ".translation"))}
    rocking = EFFECTS.whichever(lambda e: e.rocks)
    springs = tuple(Hypothesis(rocking, imu.name) for imu in recording.imus)
    state = replace(fit.state, values=fit.state.values | held)
    rigid = replace(fit, model=replace(fit.model, fixed=held), state=state)
    rigid = with_smooth_hinge(fit_with_noise(rigid.model, rigid.state, rigid.noise, rigid.anchor, rounds=1))
    begin = best_frequency(rigid, springs)
    if begin is None:
        return None
    found = first_steps(rigid, springs, begin)
    if not takes_away(fit, found):
        return None
    found = fit_with_noise(found.model, found.state, found.noise, found.anchor, rounds=REML.rounds)
    return fit_with_noise(replace(found.model, fixed=None), found.state, found.noise, found.anchor, rounds=REML.rounds)


def with_smooth_hinge(fit: Fit) -> Fit:
    """Return a fit, not solved again, whose hinge is held as smooth as the segments that it joins.

    A rigid model's hinge angle has to follow how both IMUs rock about the hinge, and is taken to be as rough as that.
    Springs would then leave it so: no sensor tells a turn of the segment about the hinge from one of its IMU.
    """
    least = min(fit.noise[name] for name in TURNING_ROUGHNESS)
    return replace(fit, noise=fit.noise | {f"smooth.{HINGE}": least})


def best_frequency(fit: Fit, springs: Sequence[Hypothesis]) -> float | None:
    """Return the frequency in Hz that springs are best begun with: first steps from there leave least.

    Of the loudest seconds alone, and up to the highest one that the samples tell: from an octave off, springs go to
    another minimum. None where samples are too slow for any.
    """
    part = excerpt(fit, *loudest(fit, ADMISSION.screened_s))
    nyquist = min(imu.rate for imu in part.model.recording.imus) / 2

    def left(hz: float) -> float:
        with suppress(NotPositiveDefiniteError):
            return left_power(first_steps(part, springs, hz))
        return np.inf

    grid = springs[0].effect.grid(part.span[1] - part.span[0])["frequency"]
    return min((float(hz) for hz in grid if hz <= nyquist), key=left, default=None)


def first_steps(fit: Fit, springs: Sequence[Hypothesis], hz: float) -> Fit:
    """Return a few steps from where springs begin with one frequency, as the motion of a fit drives them."""
    guess = {h.key("frequency"): np.full(3, np.log(hz)) for h in springs}
    begun = extended(fit, (*fit.model.hypotheses, *springs), guess)
    driven = driven_by_motion(begun.model, begun.state, springs)
    return solve(begun.model, driven, begun.noise, begun.anchor, steps=SOLVER.refit_steps)


def takes_away(fit: Fit, found: Fit, most: float = GIVING_WAY.left) -> bool:
    """Return whether what came into a fit takes away enough, by its first steps, to be what gives way.

    At most the share `most` of the gyroscopes' power that the fit leaves is then left.
    """
    return left_power(found) < most * left_power(fit)
