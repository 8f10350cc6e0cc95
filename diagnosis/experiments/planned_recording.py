"""A motion of the menu as a recording that nobody has made yet: its stamps, its model and its state."""

from dataclasses import replace

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.diagnosis.experiments.motion_menu import Stage, Swing
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, FORCE, HINGE, HINGE_AXIS, POSITION, VELOCITY
from imubench.recording import Body, Imu, Recording


def unmeasured_recording(recording: Recording, stage: Stage, seconds: float) -> Recording:
    """Return a recording of the same rig and sensors, as long as wanted, nothing measured in it yet."""
    imus = tuple(_empty(i, seconds) for i in recording.imus)
    encoders = tuple(
        replace(e, time=t, angle=np.zeros(len(t))) for e in recording.encoders for t in [_stamps(e.time, seconds)]
    )
    poses = tuple(
        replace(
            p,
            time=t,
            position=None if p.position is None else np.zeros((len(t), 3)),
            quaternion=None if p.quaternion is None else np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1)),
        )
        for p in recording.poses
        for t in [_stamps(p.time, seconds)]
    )
    body = recording.body or assumed_forearm(recording)
    if stage.loaded:
        body = Body(body.mass * (1 + stage.loaded), body.com, body.inertia)
    return replace(
        recording,
        imus=imus,
        encoders=encoders,
        poses=poses,
        body=body,
        free_swings=((0.0, seconds),) if stage.free else (),
    )


def assumed_forearm(recording: Recording) -> Body:
    """Return a forearm's mass, centre and inertia, where none is declared."""
    far = 0.15 * np.array(recording.tree.last.along or (0.0, 0.0, -1.0))
    return Body(1.0, far, np.full(3, 0.01))


def _stamps(time: Array, seconds: float) -> Array:
    step = float(np.median(np.diff(time)))
    return np.arange(0.0, seconds, step)


def _empty(imu: Imu, seconds: float) -> Imu:
    time = _stamps(imu.time, seconds)
    return replace(imu, time=time, gyro=np.zeros((len(time), 3)), accel=np.zeros((len(time), 3)))


def state_of_stage(model: Model, stage: Stage, swing: Swing | None) -> State:
    """Return the state of a model that moves as a stage says, everything else at its start."""
    knots = model.tracks.knots
    time = np.asarray(
        knots.start + knots.step * (np.arange(knots.count) - 2.0), dtype=float
    )  # the middles of the pieces
    course = stage.play(time, swing)
    if model.rig.turns and not model.rig.hinge:  # a limb: what is bent at a joint turns as one
        turn = rotations.multiply(course.turn, rotations.from_axis_angle(np.eye(3)[HINGE_AXIS], course.angle))
        course = replace(course, turn=turn)
    velocity = np.gradient(course.place, time, axis=0)
    felt = np.gradient(velocity, time, axis=0) - model.rig.gravity
    back = rotations.conjugate(course.turn)
    targets = {
        ATTITUDE: course.turn,
        POSITION: course.place,
        FORCE: rotations.rotate(back, felt),
        VELOCITY: rotations.rotate(back, velocity),
        HINGE: course.angle[:, None],
    }
    coefficients = np.zeros((knots.count, model.tracks.width))
    for name in model.tracks.widths:
        coefficients[:, model.tracks.columns(name)] = targets[name]
    return State(coefficients, {name: prior.start.copy() for name, prior in model.priors.items()})


def measured_model(model: Model, state: State) -> Model:
    """Return the model of a recording in which the IMUs have measured what the model says."""
    return replace(model, recording=readings(model, state))


def readings(model: Model, state: State) -> Recording:
    """Return a recording that nobody has made yet with what its IMUs and encoders read in a state, without noise."""
    told = {r.name: r.residual.value for r in model.measured(state)}  # the model less nothing
    imus = tuple(replace(i, gyro=told[f"{i.name}.gyro"], accel=told[f"{i.name}.accel"]) for i in model.recording.imus)
    encoders = tuple(replace(e, angle=told["encoder.angle"][:, 0]) for e in model.recording.encoders)
    return replace(model.recording, imus=imus, encoders=encoders)
