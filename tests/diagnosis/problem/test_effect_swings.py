"""The equation of motion in free swings against angular momentum in world axes, and each torque against its law."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from imubench import rotations
from imubench.diagnosis.noise.reml import fit_with_noise
from imubench.diagnosis.problem.bspline import Moment
from imubench.diagnosis.problem.dynamics_factors import inertia_about_joint, resting, turning
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.residuals import SWING_EQUATION
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, HINGE
from imubench.diagnosis.solve.gauss_newton import equation_rows, extended
from imubench.diagnosis.solve.initialize import blind_start, model_of
from imubench.diagnosis.solve.refit import information
from imubench.effects import EFFECTS, possible
from imubench.jets import Jet
from imubench.recording import Body, Encoder, Imu, Pose, Recording

BODY = Body(mass=1.2, com=[0.05, 0.02, -0.25], inertia=[0.03, 0.028, 0.002])
G = np.array([0.0, 0.0, -9.81])
SECONDS = 1.0


def recording_of(rig, **changes):
    time = np.arange(0.0, SECONDS, 0.02)
    imu = Imu("imu1", time, np.ones((len(time), 3)), np.zeros((len(time), 3)), 50.0)  # at rest nothing is asked
    poses = ()
    if rig == "hinge":
        poses = (Pose("segment1", time, np.zeros((len(time), 3)), np.tile([1.0, 0, 0, 0], (len(time), 1))),)
    given = {"imus": (imu,), "poses": poses, "body": BODY, "free_swings": ((0.1, 0.9),), "motion": "free"}
    return Recording("r", rig, **given | changes)


def random_motion(model, rng):
    tracks = model.tracks
    coefficients = 0.1 * rng.normal(size=(tracks.knots.count, tracks.width))
    for name in {ATTITUDE} & set(tracks.widths):
        coefficients[:, tracks.columns(name)] += [1.0, 0.0, 0.0, 0.0]
    return State(coefficients, {n: p.start.copy() for n, p in model.priors.items()})


def needed_torque(model, state, time):
    """d/dt (R I R' W) + m R c x (a - g) in segment axes, W and a by differences of orientations and positions."""
    h, inertia = 1e-4, inertia_about_joint(BODY)
    which = "segment2" if model.rig.hinge else "segment1"
    seen = []
    for k in (-2, -1, 0, 1, 2):
        motion = model.segments(state, Moment(model.tracks, state.coefficients, Jet((time + k * h)[:, None])))[which]
        turn = np.broadcast_to(motion.turn.matrix, (len(time), 3, 3))
        seen.append((Rotation.from_matrix(turn), np.broadcast_to(motion.position.value, (len(time), 3))))
    turns, places = zip(*seen, strict=True)

    def momentum(i):
        rate = (turns[i + 1] * turns[i - 1].inv()).as_rotvec() / (2 * h)
        return turns[i].apply(turns[i].inv().apply(rate) @ inertia)

    a = (places[3] - 2 * places[2] + places[1]) / h**2
    total = (momentum(3) - momentum(1)) / (2 * h) + np.cross(turns[2].apply(BODY.mass * BODY.com), a - G)
    rate = turns[2].inv().apply((turns[3] * turns[1].inv()).as_rotvec() / (2 * h))
    return turns[2].inv().apply(total), rate, turns[2]


def swing_residual(model, state):
    (rows,) = [r for r in equation_rows(model, state) if r.name == SWING_EQUATION]
    assert rows.time.min() >= 0.2 and rows.time.max() <= 0.8 and len(rows.time) > 10
    return rows


LAWS = {  # per unit: axis, angle, joint rate -> torque, in plain numbers
    "viscous_friction": ({"c": 0.3}, lambda axis, q, w: -0.3 * w),
    "dry_friction": ({"t": 0.4}, lambda axis, q, w: -0.4 * w / np.sqrt((w**2).sum(1, keepdims=True) + 0.02**2)),
    "air_drag": ({"d": 0.2}, lambda axis, q, w: -0.2 * np.linalg.norm(w, axis=1, keepdims=True) * w),
    "joint_spring": ({"k": 2.0, "q0": 0.3}, lambda axis, q, w: -2.0 * (q - 0.3) * axis),
    "end_stop": (
        {"angle": -0.02, "stiffness": 50.0, "damping": 0.0001},
        lambda axis, q, w: 50.0 * 0.005 * np.logaddexp(0, -(q + 0.02) / 0.005) * axis,
    ),
}


@pytest.mark.parametrize("rig", ["hinge", "pendulum", "fixed"])
@pytest.mark.parametrize("name", [None, *LAWS])
def test_the_torque_that_is_missing_is_the_one_that_the_world_needs(rig, name):
    changes = {"base": "fixed", "base_quaternion": rotations.exp(np.array([0.3, 0.2, -0.4])), "poses": ()}
    recording = recording_of("hinge", **changes) if rig == "fixed" else recording_of(rig)
    model = model_of(recording, knots_per_s=20.0)
    effects = () if name is None else (Hypothesis(EFFECTS[name], "joint"),)
    model = model.with_effects(effects)
    state = random_motion(model, np.random.default_rng(5))
    for h in effects:
        for p in h.effect.parameters:
            value = LAWS[name][0][p.name]
            state.values[h.key(p.name)][:] = np.log(value) if p.log else value
    rows = swing_residual(model, state)
    needed, rate, turn = needed_torque(model, state, rows.time)
    if rig == "pendulum":
        axis = turn.inv().apply(np.tile([0.0, 1.0, 0.0], (len(rate), 1)))
        r = turn.as_matrix()
        angle, joint = np.arctan2(r[:, 0, 2], r[:, 2, 2])[:, None], rate
    else:
        moment = Moment(model.tracks, state.coefficients, Jet(rows.time[:, None]))
        angle, axis = moment.track(HINGE).value, np.tile([0.0, 1.0, 0.0], (len(rate), 1))
        joint = moment.track(HINGE, 1).value * axis
    expected = needed if name is None else needed - LAWS[name][1](axis, angle, joint)
    expected = expected if rig == "pendulum" else expected[:, [1]]
    # differences over 1e-4 s: their truncation and rounding; the stop's damping is 1e-4 N m s/rad
    assert_allclose(rows.residual.value, expected, atol=1e-4 * max(np.abs(expected).max(), 10.0))
    assert name is None or np.abs(needed[:, [1]] - expected[:, [-1 if rig != "pendulum" else 1]]).max() > 0.01


def test_a_body_that_swings_faster_feels_more_of_every_torque():
    """I w' = scale * torque: as much as an inertia divided by it, and what is seen of the motion is not scaled away."""
    model = model_of(recording_of("pendulum"), knots_per_s=20.0).with_effects((Hypothesis(EFFECTS["inertia"], "body"),))
    state = random_motion(model, np.random.default_rng(5))
    declared = swing_residual(model, state).residual.value
    weightless = State(state.coefficients, state.values | {"inertia@body.scale": np.array([0.0])})
    inert = swing_residual(model, weightless).residual.value
    faster = State(state.coefficients, state.values | {"inertia@body.scale": np.array([1.25])})
    assert_allclose(swing_residual(model, faster).residual.value, inert + 1.25 * (declared - inert), atol=1e-9)
    rows = swing_residual(model, state)
    needed, _, turn = needed_torque(model, state, rows.time)
    body = model.recording.body
    weight = np.cross(body.mass * body.com, turn.inv().apply(np.tile([0.0, 0.0, -9.81], (len(needed), 1))))
    assert_allclose(inert, needed + weight, atol=1e-3 * np.abs(weight).max())


def test_gravity_starts_at_what_is_declared_and_pulls_the_swing():
    recording = recording_of("pendulum", gravity=9.7)
    (gravity,) = [e for e, at in possible(recording) if at == "world"]
    assert gravity.parameters[0].centre == 9.7
    model = model_of(recording, knots_per_s=20.0)
    state = random_motion(model, np.random.default_rng(5))
    bare = swing_residual(model, state).residual.value
    held = model.with_effects((Hypothesis(gravity, "world"),))
    values = {"gravity@world.g": np.array([9.7])}
    assert_allclose(swing_residual(held, State(state.coefficients, values | state.values)).residual.value, bare)
    heavier = swing_residual(held, State(state.coefficients, state.values | {"gravity@world.g": np.array([9.8])}))
    (other,) = equation_rows(model_of(recording_of("pendulum", gravity=9.8), 20.0), state)
    assert_allclose(heavier.residual.value, other.residual.value, atol=1e-12)


def test_torques_want_a_free_swing_and_a_body():
    names = {e.name for e, _ in possible(recording_of("pendulum"))}
    assert {"viscous_friction", "inertia", "moving_pivot"} <= names
    hand = {e.name for e, _ in possible(recording_of("pendulum", free_swings=(), motion="hand"))}
    assert not {"viscous_friction", "end_stop", "inertia"} & hand
    assert "inertia" not in {e.name for e, _ in possible(recording_of("pendulum", body=None))}
    assert "backlash" not in names


def test_an_encoder_alone_on_a_fixed_base_gives_the_friction():
    """A damped swing integrated apart: c within three of the fit's own standard deviations, and 3 %."""
    inertia = inertia_about_joint(BODY)[1, 1]
    c, noise = 0.03, 5e-4

    def slope(_, y):
        weight = np.cross(BODY.mass * BODY.com, Rotation.from_euler("y", y[0]).inv().apply(G))[1]
        return [y[1], (weight - c * y[1]) / inertia]

    time = np.arange(0, 8.0, 0.01)
    angle = solve_ivp(slope, (0, 8), [1.0, 0.0], t_eval=time, rtol=1e-9, atol=1e-11).y[0]
    angle = angle + noise * np.random.default_rng(2).normal(size=len(time))
    encoder = Encoder("hinge", time, angle, angle_noise_std=noise)
    recording = recording_of("hinge", imus=(), poses=(), encoders=(encoder,), base="fixed", free_swings=((0.0, 8.0),))
    model = model_of(recording)
    model, state, anchor = blind_start(model)
    levels = {"encoder.angle": noise, "smooth.hinge": 1e3, SWING_EQUATION: 1.0}
    nominal = fit_with_noise(model, state, levels, anchor)
    begun = extended(nominal, (Hypothesis(EFFECTS["viscous_friction"], "joint"),))
    fit = fit_with_noise(begun.model, begun.state, begun.noise, anchor)
    found = fit.state.values["viscous_friction@joint.c"][0]
    std = information(fit)[1]["viscous_friction@joint.c"][0]
    assert abs(found - c) < 3 * std
    assert std < 0.01 * c
    assert fit.noise[SWING_EQUATION] < 0.1 * nominal.noise[SWING_EQUATION]


def test_a_joint_at_rest_is_not_asked():
    still, moving = (resting(model, np.array([0.5, 1.5])) for model in (rested(0.01), rested(1.0)))
    assert still.all()
    assert not moving.any()


def rested(rate):
    """Return the model of a pendulum whose gyroscope reads `rate` rad/s on every axis."""
    time = np.arange(0.0, 2.0, 0.02)
    imu = Imu("imu1", time, np.full((len(time), 3), rate), np.zeros((len(time), 3)), 50.0)
    return model_of(Recording("r", "pendulum", (imu,)))


def swinging(rate, seconds=2.0):
    """Return a hinge's model whose IMU turns at `rate`, a function of time, about the hinge."""
    time = np.arange(0.0, seconds, 0.01)
    gyro = np.stack([0.0 * time, rate(time), 0.0 * time], axis=1)
    imu = Imu("imu1", time, gyro, np.zeros((len(time), 3)), 100.0)
    recording = Recording(
        *("r", "hinge"), imus=(imu,), base="fixed", base_quaternion=[1.0, 0, 0, 0], body=BODY, motion="free",
        free_swings=((0.0, seconds),),
    )  # fmt: skip
    return model_of(recording, knots_per_s=100.0)


def test_the_equation_is_not_asked_where_a_swing_turns_round_but_where_a_stop_turns_it():
    """Friction that jumps is rounded by a spline over two intervals; what a stop does takes longer, and is the law."""
    times = np.arange(0.005, 1.99, 0.01)
    calm = times[turning(swinging(lambda t: 2.0 * np.cos(5.0 * t)), BODY, times)]
    turns = np.array([1, 3, 5]) * np.pi / 10  # of 2 cos 5 t
    assert all(np.abs(turns - t).min() <= 0.0201 for t in calm) and len(calm) == 4 * len(turns)
    assert not turning(swinging(lambda t: 2.0 * np.sign(np.cos(5.0 * t))), BODY, times).any()
