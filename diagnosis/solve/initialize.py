"""A start from the recording alone: clocks aligned, attitude integrated and levelled, hinge angle matched."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from scipy.ndimage import gaussian_filter1d

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.config.solve import START
from imubench.diagnosis.problem.averaging import AS_RECORDED, Averaging
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.bspline import Knots, Moment, Tracks
from imubench.diagnosis.problem.hypothesis import Geometry, Hypothesis, State
from imubench.diagnosis.problem.motion_prior import START_SMOOTH, prior_rows
from imubench.diagnosis.problem.residuals import Rows
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, FORCE, HINGE, HINGE_AXIS, POSITION, Rig
from imubench.diagnosis.samples.rest_noise import least_noise
from imubench.diagnosis.solve.clock_offsets import coarse, late, on_segments
from imubench.diagnosis.solve.gauss_newton import Step
from imubench.diagnosis.solve.retract import moved
from imubench.diagnosis.solve.threads import one_thread
from imubench.effects import EFFECTS, delay_law
from imubench.jets import Jet
from imubench.recording import Recording


def model_of(recording: Recording, knots_per_s: float | None = None, averaging: Averaging = AS_RECORDED) -> Model:
    """Return the model of a recording as its owner declares it, no effect in it.

    Knots are as dense as the samples of the slowest IMU that can move. `averaging` is of its samples; effects
    count their time from its first stamp.
    """
    rig = Rig.of(recording)
    stamps = [i.time for i in recording.imus] + [e.time for e in recording.encoders] + [p.time for p in recording.poses]
    start, end = min(t[0] for t in stamps), max(t[-1] for t in stamps)
    clocks = [i.time for i in recording.moving] or stamps
    rate = knots_per_s or min(START.most_knots_per_s, *[1 / float(np.median(np.diff(t))) for t in clocks])
    mounts = {i.name: Geometry(i.mount_position, rotations.to_matrix(i.mount_quaternion)) for i in recording.imus}
    zero = float(start) if averaging.zero is None else averaging.zero
    beside = START.edge_s + START.most_offset_s
    knots = Knots.over(start - zero - beside, end - zero + beside, 1 / rate)
    model = Model(recording, rig, Tracks(knots, rig.widths), mounts, zero, least_noise(recording), averaging=averaging)
    return replace(model, tracks=Tracks(_needed(knots, (0.0, *late(model).values())), rig.widths))


def _needed(knots: Knots, offsets: Sequence[float]) -> Knots:
    """Return the knots without those that no clock that is late by one of some offsets in s leads to.

    Where no sample holds them only priors tie attitude, force and velocity to each other, and the solver takes many
    short steps to let them follow what the samples say.
    """
    first, last = (
        max(int((START.most_offset_s - late_by) / knots.step), 0) for late_by in (max(offsets), -min(offsets))
    )
    return Knots(knots.start + first * knots.step, knots.step, knots.count - first - last)


@one_thread
def blind_start(model: Model) -> tuple[Model, State, Array | None]:
    """Return the model, a state to begin the fit from, and the first attitude (4,) if there is one.

    Clocks that are far apart are in the model from the start: no other effect could be judged before.
    """
    recording, rig = model.recording, model.rig
    values = {name: prior.start.copy() for name, prior in model.priors.items()}
    knots = model.tracks.knots
    grid = np.asarray(knots.start + knots.step * np.arange(knots.count - 5), dtype=float)
    targets: dict[str, Array] = {}
    offsets = late(model)
    for at, offset in offsets.items():
        clock = Hypothesis(delay_law(), at)
        if abs(offset) > coarse(recording) and clock.effect.name in EFFECTS:
            model = model.with_effects((*model.hypotheses, clock))
            values[clock.key(clock.effect.late_by)] = np.array([offset])
    sampled = on_segments(model, grid, offsets)
    if rig.turns:
        if recording.poses and recording.poses[0].quaternion is not None:
            targets[ATTITUDE] = _interpolated(model, grid, "quaternion")
        else:
            gyro, accel = _foremost(rig, sampled)
            targets[ATTITUDE] = levelled(gyro, accel, knots.step, still=not rig.moves)
    if FORCE in model.tracks.widths:
        targets[FORCE] = _foremost(rig, sampled)[1]
    if POSITION in model.tracks.widths:
        targets[POSITION] = _interpolated(model, grid, "position")
    if rig.hinge:
        targets[HINGE] = hinge_angle(model, grid, sampled)[:, None]
    coefficients = np.zeros((knots.count, model.tracks.width))
    if ATTITUDE in targets:
        coefficients[:, model.tracks.columns(ATTITUDE)] = targets[ATTITUDE][0]
    anchor = targets[ATTITUDE][0] if ATTITUDE in targets else None
    state = State(coefficients, values)
    return model, _follow(model, state, grid, targets, anchor), anchor


def _foremost(rig: Rig, sampled: dict[str, tuple[Array, Array]]) -> tuple[Array, Array]:
    """Return rate and specific force of the IMU that is nearest to the base."""
    return sampled[min(sampled, key=rig.tree.imus.index)]


def _follow(model: Model, state: State, grid: Array, targets: dict[str, Array], anchor: Array | None) -> State:
    """Return the splines through the targets (n, width)."""
    moment = Moment(model.tracks, state.coefficients, Jet(grid[:, None]))
    rows = [Rows(n, grid, moment.track(n) - y, np.full(y.shape[1], 1e-3)) for n, y in targets.items()]
    noise = {f"smooth.{n}": START_SMOOTH.get(n, 1e4) for n in model.tracks.widths}
    step = Step.of(model, rows + list(prior_rows(model, state, noise, anchor)))
    return moved(model, state, step.splines, step.values)


def integrated(rate: Array, step: float) -> Array:
    """Return the attitudes (n, 4) that a body rate (n, 3) rad/s leads to, from the identity."""
    q = rotations.exp(np.concatenate([np.zeros((1, 3)), 0.5 * (rate[1:] + rate[:-1]) * step]))
    reach = 1
    while reach < len(q):  # a running product in log2(n) passes
        q[reach:] = rotations.multiply(q[:-reach].copy(), q[reach:])
        reach *= 2
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def levelled(rate: Array, force: Array, step: float, still: bool) -> Array:
    """Return attitudes (n, 4), continuous, whose mean specific force points up; `still`: the origin does not move."""
    q = integrated(rate, step)
    width = (0.5 if still else START.levelling_s) / step
    for _ in range(3):
        up = gaussian_filter1d(rotations.rotate(q, force), width, axis=0, mode="nearest")
        up /= np.linalg.norm(up, axis=1, keepdims=True)
        q = rotations.multiply(least_turn(up, np.array([0.0, 0.0, 1.0])), q)
    return q


def least_turn(u: Array, v: Array) -> Array:
    """Return the least turns (n, 4) that take unit vectors u (n, 3) to v (3,), across x; opposite ones turn about x."""
    cosine = 1 + u @ v
    q = np.concatenate([cosine[:, None], np.cross(u, v)], axis=1)
    q[cosine < 1e-9] = [0.0, 1.0, 0.0, 0.0]
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def _interpolated(model: Model, grid: Array, what: Literal["position", "quaternion"]) -> Array:
    """Return the first measured position (n, 3) or quaternion (n, 4), continuous, on the grid."""
    pose, measured = next((p, y) for p in model.recording.poses if (y := getattr(p, what)) is not None)
    seen = np.isfinite(measured).all(axis=1)
    y = rotations.continuous(measured[seen]) if what == "quaternion" else measured[seen]
    out = np.stack([np.interp(grid, pose.time[seen] - model.start, x) for x in y.T], axis=1)
    return out / np.linalg.norm(out, axis=1, keepdims=True) if what == "quaternion" else out


def hinge_angle(model: Model, grid: Array, sampled: dict[str, tuple[Array, Array]]) -> Array:
    """Return the hinge angle (n,) rad: integrated, then moved to where the specific forces agree."""
    recording = model.recording
    if recording.encoders:
        encoder = recording.encoders[0]
        return np.interp(grid, encoder.time - model.start, encoder.angle + encoder.zero)
    one, two = model.rig.tree.pair or ("", "")
    if two not in sampled:
        return np.zeros(len(grid))
    gyro2, force2 = sampled[two]
    if one in sampled and model.rig.turns:
        gyro1, force1 = sampled[one]
    else:
        gyro1, force1 = np.zeros_like(gyro2), np.tile(-model.rig.base.T @ model.rig.gravity, (len(grid), 1))
    rate = (gyro2 - gyro1)[:, HINGE_AXIS]
    step = model.tracks.knots.step
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * step)])
    turn1, turn2 = (np.arctan2(f[:, 0], f[:, 2]) for f in (force1, force2))
    weight = np.hypot(force1[:, 0], force1[:, 2]) * np.hypot(force2[:, 0], force2[:, 2])
    gap = weight * np.exp(1j * (turn1 - turn2 - angle))
    smooth = gaussian_filter1d(gap.real, START.levelling_s / step) + 1j * gaussian_filter1d(
        gap.imag, START.levelling_s / step
    )
    return angle + np.unwrap(np.angle(smooth))


__all__ = ["blind_start", "hinge_angle", "least_turn", "levelled", "model_of"]
