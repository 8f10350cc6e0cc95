"""Where a step leads: the state moved by it, and what follows from the rest of the state solved for that."""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import Tracks
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.motion_prior import pace_rows
from imubench.diagnosis.problem.residuals import Rows
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, FORCE, VELOCITY
from imubench.diagnosis.problem.sensor_axes import SENSOR, turns_back
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import assemble, own_rows
from imubench.diagnosis.solve.narrow_band import eased
from imubench.jets import derivatives_by


def moved(model: Model, state: State, x: Array, values: Array) -> State:
    """Return a state moved by x (blocks, b) and `values` (p,); segment 1 turns back as its sensor's mount turns.

    In splines of the segment's attitude and force a turn of the mount by 0.03 rad would leave errors of second order
    that gyroscopes see, and steps would be cut to hundredths.
    """
    count, width = state.coefficients.shape
    change = x.reshape(-1, width)[:count]
    parameters, tracks = model.parameters, model.tracks
    new = {name: value + values[parameters.columns(name)] for name, value in state.values.items()}
    coefficients = state.coefficients + change
    if SENSOR in model.mounts and ATTITUDE in tracks.widths:
        back, slope = turns_back(model, state.values, new)
        own = tracks.columns(ATTITUDE)
        q = state.coefficients[:, own]
        straight = coefficients[:, own] - rotations.multiply(q, np.concatenate([[0.0], slope / 2]))
        coefficients[:, own] = rotations.multiply(straight, rotations.from_matrix(back))
        for name in tracks.widths.keys() & {FORCE, VELOCITY}:
            own = tracks.columns(name)
            coefficients[:, own] = (coefficients[:, own] + np.cross(slope, state.coefficients[:, own])) @ back
    return State(coefficients, new)


def followed(model: Model, state: State, rows: list[Rows], damping: float) -> State:
    """Return a state whose splines follow the parameters that a step led to: what it left of second order is gone.

    What a step leaves of second order may exceed what it gains, as of a mount's turn beside a skin that slides. Where
    nothing holds a spline all stay.
    """
    normal, _ = assemble(model, rows)
    normal.damp(damping)
    with suppress(NotPositiveDefiniteError):
        x = normal.band.factor().solve(-normal.gradient[:, :, None])
        return moved(model, state, x[:, :, 0], np.zeros(model.parameters.count))
    return state


def with_centre_velocity(model: Model, state: State) -> State:
    """Return the state with the joint centre's velocity solved for everything else as it is.

    It is an integral of attitude and force, held tightly, and linear: what a step leaves of second order in it cost
    more than the step had gained, so that steps were cut to fifths.
    """
    if VELOCITY not in model.tracks.widths:
        return state
    only = Tracks(model.tracks.knots, {VELOCITY: model.tracks.widths[VELOCITY]})
    with derivatives_by(only.widths):
        rows = list(pace_rows(model, state))
    return shifted(model, state, only, eased(only, rows, ALGEBRA.damped))


def settled(model: Model, state: State, noise: dict[str, float], loose: float = 1.0) -> State:
    """Return the state with the effects' own splines solved for everything else as it is.

    A spring's law is tight and nearly linear in what hangs on it, but not in both it and the spring's constants:
    without this a step in a frequency breaks the law and is taken back.
    """
    own = {h.key(s.name): s.width for h in model.hypotheses for s in h.effect.states}
    if not own:
        return state
    only = Tracks(model.tracks.knots, own)
    size = np.concatenate([np.full(s.width, s.std) for h in model.hypotheses for s in h.effect.states])
    places = {h.at for h in model.hypotheses if h.effect.states}
    alone = places if places <= {imu.name for imu in model.recording.imus} else ()  # a joint's states move all sensors
    for _ in range(ALGEBRA.spline_solves):
        change = eased(only, own_rows(model, state, noise, loose, alone, own), ALGEBRA.damped)
        state = shifted(model, state, only, change)
        if np.max(np.abs(change) / size) < ALGEBRA.moved:
            break
    return state


def shifted(model: Model, state: State, only: Tracks, change: Array) -> State:
    """Return a state with some of its splines moved by `change` (knots or more, width of `only`)."""
    coefficients = state.coefficients.copy()
    for name in only.widths:
        coefficients[:, model.tracks.columns(name)] += change[: only.knots.count, only.columns(name)]
    return replace(state, coefficients=coefficients)
