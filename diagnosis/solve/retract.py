"""Where a step leads: the state moved by it."""

from dataclasses import replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import Tracks
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, FORCE, VELOCITY
from imubench.diagnosis.problem.sensor_axes import first_sensor, turns_back


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
    if first_sensor(model.rig, model.mounts) is not None and ATTITUDE in tracks.widths:
        back, slope = turns_back(model.rig, model.mounts, state.values, new)
        own = tracks.columns(ATTITUDE)
        q = state.coefficients[:, own]
        straight = coefficients[:, own] - rotations.multiply(q, np.concatenate([[0.0], slope / 2]))
        coefficients[:, own] = rotations.multiply(straight, rotations.from_matrix(back))
        for name in tracks.widths.keys() & {FORCE, VELOCITY}:
            own = tracks.columns(name)
            coefficients[:, own] = (coefficients[:, own] + np.cross(slope, state.coefficients[:, own])) @ back
    return State(coefficients, new)


def shifted(model: Model, state: State, only: Tracks, change: Array) -> State:
    """Return a state with some of its splines moved by `change` (knots or more, width of `only`)."""
    coefficients = state.coefficients.copy()
    for name in only.widths:
        coefficients[:, model.tracks.columns(name)] += change[: only.knots.count, only.columns(name)]
    return replace(state, coefficients=coefficients)
