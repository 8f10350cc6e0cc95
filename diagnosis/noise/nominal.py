"""The fit of a recording as it was declared, begun from the recording alone."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from imubench.arrays import Array
from imubench.diagnosis.config.noise import COHERENCE, LOOSE_FIT
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.noise.coherence import follows_motion
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.looser_motion import rougher
from imubench.diagnosis.noise.reml import fit_with_noise, with_noise
from imubench.diagnosis.problem.averaging import AS_RECORDED, Averaging
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.motion_prior import START_SMOOTH, prior_rows
from imubench.diagnosis.samples.pose_correlation import GaussMarkov
from imubench.diagnosis.solve.gauss_newton import equation_rows
from imubench.diagnosis.solve.initialize import blind_start, model_of
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.effects import EFFECTS
from imubench.effects.triples import accel_ahead
from imubench.recording import Recording
from imubench.slope import slope_of

START_NOISE = {"gyro": 0.3, "accel": 1.0, "angle": 0.01, "position": 0.01, "rotation": 0.02}  # loose: rad/s, m/s^2, ...


def nominal_fit(
    recording: Recording,
    masks: dict[str, NDArray[np.bool_]] | None = None,
    humming: Mapping[str, float] | None = None,
    wander: Mapping[str, GaussMarkov] | None = None,
    known: tuple[Hypothesis, ...] = (),
    averaging: Averaging = AS_RECORDED,
) -> Fit:
    """Return the fit of the model as it was declared, noise levels estimated.

    `masks` says which samples count, `humming` names the IMUs whose raw samples hum, with the frequency in Hz; `known`
    are effects that are known beforehand, `averaging` is of the recording's samples.
    """
    model = model_of(recording, averaging=averaging)
    smoothed = tuple(name for name in model.poses if f"{name}.rotation" in (masks or {}))
    model = replace(model, masks=masks or None, humming=humming or {}, wander=wander or {}, smoothed=smoothed)
    known = (*known, *ahead(model))
    model = model.with_effects(known)
    start = first_fit(model.with_effects((*known, *biases(model))))
    model, anchor = start.model, start.anchor
    fit = fit_with_noise(model, start.state, start.noise | declared(model), anchor, motion=True)
    fit = with_freer_motion(fit)
    laws = {r.name for r in equation_rows(model, start.state)}
    if not laws:
        return fit
    sensors = {name: std for name, std in fit.noise.items() if name not in laws}
    fit = fit_with_noise(model, fit.state, sensors | dict.fromkeys(laws, 1.0), anchor, rounds=4, only=laws)
    return fit


def first_fit(model: Model, steps: int = SOLVER.steps) -> Fit:
    """Return a first fit from the recording alone, at noise levels that hold nothing tightly."""
    model, state, anchor = blind_start(model)
    noise = {r.name: START_NOISE[r.name.split(".")[1]] for r in model.measured(state)}
    noise |= roughness(model, state, anchor) | {r.name: LOOSE_FIT.equation for r in equation_rows(model, state)}
    return solve(model, state, noise, anchor, steps, enough=1e-3)


def certain_effects(model: Model) -> tuple[str, ...]:
    """Return the effects that are there whatever else is: beside a pose whose errors wander, what every sensor has.

    A curve without a name that does as much as a clock's offset or a gyroscope's bias would be the pose's own errors.
    """
    return tuple(name for name, effect in EFFECTS.items() if effect.in_every_sensor) if model.wander else ()


def ahead(model: Model) -> tuple[Hypothesis, ...]:
    """Return by how much accelerometers are ahead of their gyroscopes, beside smoothed poses that tell both's times.

    An attitude has the clock of a gyroscope, a position that of an accelerometer. One offset for both, a mount on
    springs or a curve without a name would stand in for what two filters of one sensor differ by.
    """
    poses = [model.poses[name] for name in model.smoothed]
    both = {p.segment for p in poses if p.position is not None and p.quaternion is not None}
    imus = [i for i in model.recording.imus if model.recording.carrier(i.name) in both]
    return tuple(Hypothesis(accel_ahead(i.time - model.start, slope_of(i.accel, i.rate)), i.name) for i in imus)


def biases(model: Model) -> tuple[Hypothesis, ...]:
    """Return the biases of gyroscopes beside poses whose errors wander, to be in the fit from the start.

    Every gyroscope has one. Beside errors that go with the attitude a g-sensitivity of nine numbers takes its place,
    then what remains of a scale. It goes again if it predicts nothing.
    """
    segments = {model.poses[name].segment for name in model.wander}
    known = {h.at for h in model.hypotheses if list(h.effect.known_parts())}
    imus = [i.name for i in model.recording.imus if model.recording.carrier(i.name) in segments and i.name not in known]
    every = [effect for effect in EFFECTS.values() if effect.in_every_sensor and effect.acts("error")]
    return tuple(Hypothesis(effect, at) for effect in every for at in imus)


def roughness(model: Model, state: State, anchor: Array | None) -> dict[str, float]:
    """Return how rough the motion may be at first: the first guess, or a multiple of what the start has already.

    A quick turn that is held too smooth costs least where its quaternion shrinks: at 9 rad/s to a tenth of its norm,
    after which hardly a step is a whole one.
    """
    guess = {f"smooth.{name}": START_SMOOTH[name] for name in model.tracks.widths if name in START_SMOOTH}
    for rows in prior_rows(model, state, guess, anchor):
        if rows.name in guess and (rough := float(np.sqrt(np.mean(rows.whitened**2)))) > 1.0:
            guess[rows.name] *= LOOSE_FIT.start_roughness * rough
    return guess


def with_freer_motion(fit: Fit) -> Fit:
    """Return the fit with its motion held less smooth, where that is all that its residuals had against it.

    One roughness for rests and quick strokes may be too small for the strokes; what a sensor does of its own shows
    against the other sensors, however rough the motion may be.
    """
    found = max(follows_motion(fit).values(), default=0.0)
    if found < COHERENCE.follows:
        return fit
    freer = rougher(fit)
    if max(follows_motion(freer).values()) > LOOSE_FIT.still_follows * found:
        return fit
    freer = with_noise(freer)
    return freer if max(follows_motion(freer).values()) < 1.0 else fit


__all__ = ["first_fit", "nominal_fit", "with_freer_motion"]
