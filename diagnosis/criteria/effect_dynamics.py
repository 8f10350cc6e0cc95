"""What the states of an effect do by its law, once a motion drives it."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import LAW
from imubench.diagnosis.config.solve import ALGEBRA, START
from imubench.diagnosis.noise.coherence import clear_at, slower
from imubench.diagnosis.problem.batch_model import Model, inside
from imubench.diagnosis.problem.bspline import SUPPORT, Moment, Tracks
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.motion_prior import smooth_rows
from imubench.diagnosis.problem.process_factors import scenes, state_rows
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.solve.linearize import linearise
from imubench.diagnosis.solve.narrow_band import solved
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.diagnosis.solve.retract import shifted
from imubench.effects.effect import Effect
from imubench.jets import Jet


def with_clear_motion(fit: Fit, imu: str) -> State:
    """Return the fit's state with its motion only as quick as it is more than an IMU's noise.

    What a fitted motion has beyond is the noise of samples, and springs resound with it: the score of a spring beyond
    the motion's band is then about that noise.
    """
    tracks, time = fit.model.tracks, inside(fit.model)
    start, step = tracks.knots.start, tracks.knots.step
    with_samples = slice(int((time[0] - start) / step) + 1, int((time[-1] - start) / step) + SUPPORT)
    cut, coefficients = clear_at(fit, imu), fit.state.coefficients.copy()
    for name in fit.model.rig.widths:
        columns = tracks.columns(name)
        coefficients[with_samples, columns] = slower(coefficients[with_samples, columns], cut, 1 / step)
    return replace(fit.state, coefficients=coefficients)


def solved_by_law(model: Model, state: State, h: Hypothesis, drive: State | None = None) -> tuple[State, Array]:
    """Return the state with h's splines as its law says, and what they do (m, b, p) when a parameter moves.

    The motion of `drive` moves them, or else the state's own.

    What a law leaves open, how its state begins, is as smooth as a fit would have it: held at zero instead, a mount
    that sags on its springs rings from the first sample on. A filter has no sag, and forgets.
    """
    own = Tracks(model.tracks.knots, {h.key(s.name): s.width for s in h.effect.states})
    shared = Parameters({h.key(p.name): p.width for p in h.effect.parameters})
    step = model.tracks.knots.step
    if not own.widths:
        return state, np.zeros((model.tracks.knots.count, 0, shared.count))
    begun, (state, passes) = state, followed(model, drive or state, h)
    levels = {f"smooth.{h.key(s.name)}": START.lawful_state_roughness * s.std for s in h.effect.states}
    smooth, held = ([], LAW.told_state) if h.effect.filters else (list(own.widths), LAW.loose_state)
    for turn in range(passes):
        normal = Normal.empty(own, shared)
        rows = [*state_rows(model, state, h), *smooth_rows(model, state, levels, smooth)]
        normal.add([linearise(r, own, shared) for r in rows])
        normal.fill(own)
        for s in h.effect.states:
            _held(normal, own, h.key(s.name), held / s.std, step)
        last = turn + 1 == passes
        asked = [normal.gradient[:, :, None], normal.border] if last else [normal.gradient[:, :, None]]
        moves = -solved(normal, np.concatenate(asked, axis=2))
        sensitivity = moves[:, :, 1:]
        state = shifted(model, state, own, moves[:, :, 0].reshape(-1, own.width))
    coefficients = begun.coefficients.copy()
    for name in own.widths:
        coefficients[:, model.tracks.columns(name)] = state.coefficients[:, model.tracks.columns(name)]
    return replace(begun, coefficients=coefficients), sensitivity


def driven_by_motion(model: Model, state: State, hypotheses: Iterable[Hypothesis]) -> State:
    """Return the state with the splines of effects that obey a law as the motion drives them."""
    for h in hypotheses:
        if h.effect.lawful:
            state = solved_by_law(model, state, h)[0]
    return state


def followed(model: Model, state: State, h: Hypothesis) -> tuple[State, int]:
    """Return the state with h's splines where the effect itself says they are, and how many solves are left to do."""
    if type(h.effect).follow is Effect.follow:
        return state, ALGEBRA.spline_solves
    ((_, scene),) = scenes(model, state, h)
    told = h.effect.follow(scene, model.values(h, state))
    if not told:
        return state, ALGEBRA.spline_solves
    time, coefficients = inside(model), state.coefficients.copy()
    for name, value in told.items():
        own = Tracks(model.tracks.knots, {h.key(name): value.shape[1]})
        track = Moment(own, np.zeros((own.knots.count, own.width)), Jet(time[:, None])).track(h.key(name))
        normal = Normal.empty(own, Parameters({}))
        normal.add([linearise(Rows("follow", time, track - value, np.ones(own.width)), own, Parameters({}))])
        normal.fill(own)
        _held(normal, own, h.key(name), LAW.told_state, 1.0)
        move = -solved(normal, normal.gradient[:, :, None]).reshape(-1, own.width)
        coefficients[:, model.tracks.columns(h.key(name))] = move[: own.knots.count]
    return replace(state, coefficients=coefficients), 1


def _held(normal: Normal, tracks: Tracks, name: str, weight: float, step: float) -> None:
    """Hold a spline's coefficients weakly at zero."""
    b = normal.diagonal.shape[1]
    at = np.arange(b).reshape(-1, tracks.width)[:, tracks.columns(name)].reshape(-1)
    normal.diagonal[:, at, at] += step * weight**2


__all__ = ["driven_by_motion", "solved_by_law", "with_clear_motion"]
