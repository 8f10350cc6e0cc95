"""Joints that do more than turn: coupled axes, centres that move, play between stops, stops, and torques on a ball."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from imubench import rotations
from imubench.errors import InputError
from imubench.proof.swing import Ball
from imubench.proof.torques import Torques
from imubench.sim import rigs
from imubench.sim.compile import compile_model
from imubench.sim.joints import Play, Stop
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.rigs import Mount, Segment, Slip, springs
from imubench.sim.signals import Sines
from imubench.sim.swing import Start, swing

GRAVITY = np.array([0.0, 0.0, 9.81])
COUPLING, CENTRE = np.array([0.1, -0.2]), np.array([0.02, -0.01, 0.015])
SPRINGY = Play(0.3, 0.7, frequency=5.0, damping_ratio=0.2, share=0.5)
KINDS = {
    "coupling": {"coupling": COUPLING},
    "centre": {"centre": CENTRE},
    "both": {"coupling": COUPLING, "centre": CENTRE},
    "springy play": {"play": SPRINGY},
    "told play": {"play": Play(0.3, 0.7, path=(Sines(0.05, 1.3), Sines(0.03, 2.1, 1)))},
    "all": {"coupling": COUPLING, "centre": CENTRE, "play": SPRINGY},
}
LIMB = Segment(1.5, np.array([0.01, -0.008, -0.2]), np.array([0.02, 0.021, 0.002]))
PENDULUM = rigs.pendulum(segments=(LIMB,), mounts=(Mount(np.array([0.02, 0.01, -0.2]), mass=1e-6),))
WEIGHT = LIMB.mass * 9.81 * 0.2  # N m
LET_GO = Start(
    quaternion=rotations.multiply(rotations.exp(np.array([0, 0.9, 0])), rotations.exp(np.array([0.3, 0, 0]))),
    rate=np.array([0.3, 0.2, 1.5]),
)


def moved() -> AngleMotion:
    ways = {"heading": 1.0, "tilt": 0.4, "spin": 0.8, "angle": 0.7, "x": 0.1}
    return AngleMotion(**{key: Sines(a, 0.7 + 0.1 * i, i) for i, (key, a) in enumerate(ways.items())})


def hinge(mount=None, **changes):
    second = Mount(np.array([0.1, 0.02, 0.03]), rotations.exp(np.array([0.4, -1.0, 0.3])), **(mount or {}))
    return rigs.hinge(mounts=(Mount(), second), **changes)


def differences(place, quaternion, h):
    """Specific force and rate (n - 2, 3) in own axes of what moves so, by differences of order 2."""
    second = np.diff(place, 2, axis=0) / h**2
    force = rotations.rotate_back(quaternion[1:-1], second + GRAVITY)
    rate = rotations.log(rotations.multiply(rotations.conjugate(quaternion[:-2]), quaternion[2:])) / (2 * h)
    return force, rate


@pytest.mark.parametrize("kind", KINDS)
def test_sensors_and_segments_read_how_they_move(kind):
    h = 5e-4
    truth = play(hinge(**KINDS[kind]), moved(), 1.0, 1 / h)
    sensor, segment = truth.sensors[1], truth.segments[1]
    force, rate = differences(sensor.position, sensor.quaternion, h)
    # Of order 2: h^2 / 12 times the fourth derivative, 0.1 m (2 pi 3 Hz)^4, and h^2 / 6 times 3 rad/s (2 pi 3 Hz)^2.
    assert_allclose(sensor.specific_force[1:-1], force, atol=3e-4)
    assert_allclose(sensor.gyro[1:-1], rate, atol=1e-4)
    _, rate = differences(segment.position, segment.quaternion, h)
    assert_allclose(segment.rate[1:-1], rate, atol=1e-4)
    assert_allclose(segment.velocity[1:-1], (segment.position[2:] - segment.position[:-2]) / (2 * h), atol=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_a_sensor_on_springs_reads_how_it_moves(kind):
    h = 5e-4
    rocking = {"rotation": springs(12.0, 0.1), "com": np.array([0.004, 0.0, 0.002]), "lever": np.array([0, 0, 0.01])}
    sensor = play(hinge(rocking, **KINDS[kind]), moved(), 1.0, 1 / h).sensors[1]
    force, rate = differences(sensor.position, sensor.quaternion, h)
    # As above, and the springs: h^2 / 12 times 0.01 m 0.2 rad (2 pi 12 Hz)^4, and h^2 / 6 times 2 rad/s (2 pi 12 Hz)^2.
    assert_allclose(sensor.specific_force[1:-1], force, atol=2e-3)
    assert_allclose(sensor.gyro[1:-1], rate, atol=6e-4)


def test_the_chain_is_the_law_s():
    """R_2 = R_1 Ry(q) Rx(c1 q) Rz(c2 q), segment 2's origin at slide q in segment 1."""
    truth = play(hinge(coupling=COUPLING, centre=CENTRE), moved(), 1.0, 100.0)
    first, second, q = *truth.segments, truth.joint_angle
    turns = np.zeros((3, q.size, 3))
    turns[0, :, 1], turns[1, :, 0], turns[2, :, 2] = q, COUPLING[0] * q, COUPLING[1] * q
    expected = first.quaternion
    for vector in turns:
        expected = rotations.multiply(expected, rotations.exp(vector))
    assert_allclose(np.abs(np.sum(expected * second.quaternion, axis=1)), 1.0, atol=1e-12)  # rounding
    moved_by = rotations.rotate_back(first.quaternion, second.position - first.position)
    assert_allclose(moved_by, np.outer(q, CENTRE), atol=1e-12)


def test_an_undriven_rig_holds_its_gears():
    """Equalities of MuJoCo, as the MJCF file has them."""
    model = compile_model(rigs.hinge(coupling=COUPLING, centre=CENTRE, base="fixed"))
    data = mujoco.MjData(model)
    for _ in range(300):
        mujoco.mj_step(model, data)
    q = data.joint("hinge").qpos[0]
    assert abs(q) > 0.1
    got = [data.joint(name).qpos[0] for name in ("coupling_x", "coupling_z", "centre")]
    assert_allclose(
        got, q * np.array([*COUPLING, np.linalg.norm(CENTRE)]), atol=2e-3
    )  # equalities of MuJoCo give way a little


def test_a_springy_play_obeys_its_law():
    """Euler about the joint, w and f those of segment 2: e . (inertia w' + w x inertia w + m c x f) is the springs'."""
    h, joint = 1e-3, replace(SPRINGY, share=1.0)
    rig = hinge(play=joint)
    rig = replace(rig, mounts=tuple(replace(m, mass=1e-7) for m in rig.mounts))  # which are not in `about`
    truth = play(rig, moved(), 1.5, 1 / h)
    segment, own, half = truth.segments[1], rig.segments[1], truth.joint_angle / 2
    about_y = np.stack([np.cos(half), 0 * half, np.sin(half), 0 * half], axis=1)
    relative = rotations.multiply(rotations.conjugate(truth.segments[0].quaternion), segment.quaternion)
    phi = rotations.log(rotations.multiply(rotations.conjugate(about_y), relative)) @ joint.axis
    about = np.diag(own.inertia) + own.mass * (own.com @ own.com * np.eye(3) - np.outer(own.com, own.com))
    force, w = rotations.rotate_back(segment.quaternion, segment.acceleration + GRAVITY), segment.rate
    turning = segment.angular_acceleration @ about + np.cross(w, w @ about)
    needed = (turning + own.mass * np.cross(own.com, force)) @ joint.axis
    J, W = joint.axis @ about @ joint.axis, 2 * np.pi * joint.frequency
    given = -J * (W**2 * phi + 2 * joint.damping_ratio * W * np.gradient(phi, h))
    inner = slice(2, -2)
    assert_allclose(needed[inner], given[inner], atol=1e-4 * np.abs(given).max())  # differences of order 2


def test_a_free_play_leans_on_its_stops_and_falls_between_them():
    joint = Play(0.03, 0.7)
    truth = play(hinge(play=joint), moved(), 3.0, 400.0)
    half = truth.joint_angle / 2
    about_y = np.stack([np.cos(half), 0 * half, np.sin(half), 0 * half], axis=1)
    relative = rotations.multiply(rotations.conjugate(truth.segments[0].quaternion), truth.segments[1].quaternion)
    turned = rotations.log(rotations.multiply(rotations.conjugate(about_y), relative))
    phi = turned @ joint.axis
    assert_allclose(turned, np.outer(phi, joint.axis), atol=1e-9)  # about its axis alone
    assert np.abs(phi).max() < 1.5 * joint.range  # a limb that falls through 60 mrad meets its stop at 1 rad/s
    assert np.quantile(np.abs(phi), 0.5) > 0.95 * joint.range  # mostly it leans
    assert phi.max() > joint.range > -joint.range > phi.min()


def test_a_mount_may_slip_and_slide_on_its_springs():
    h = 2.5e-4
    mount = {
        "translation": springs(9.0, 0.1), "rotation": springs(12.0, 0.2), "slide": [0.02, -0.01, 0.015],
        "twist": [0.1, -0.2, 0.05], "slip": Slip(0.3, np.array([0.01, 0.02, -0.03]), np.array([0.2, 0.1, -0.3])),
    }  # fmt: skip
    truth = play(hinge(mount), moved(), 0.8, 1 / h)
    sensor = truth.sensors[1]
    force, rate = differences(sensor.position, sensor.quaternion, h)
    # At both ends of the slip the jerk jumps by 60 * 0.03 / 0.2^3 = 225 m/s^3: h / 6 of it.
    assert_allclose(sensor.specific_force[1:-1], force, atol=2e-2)
    assert_allclose(sensor.gyro[1:-1], rate, atol=2e-3)


@pytest.mark.parametrize(
    ("changes", "laws"),
    [
        ({"damping": 0.02, "inertia_scale": 1.3}, {"c": 0.02, "scale": 1.3}),
        ({"damping": 0.02, "inertia_scale": 0.8}, {"c": 0.02, "scale": 0.8}),
        ({"drag": 0.02}, {"d": 0.02}),
        (
            {"damping": 0.02, "stiffness": 0.5 * WEIGHT, "spring_angle": 0.3, "spring_conserves": True},
            {"c": 0.02, "k": 0.5 * WEIGHT, "q0": 0.3},
        ),
    ],
    ids=["light", "heavy", "drag", "spring"],
)
def test_a_limb_on_a_ball_joint_swings_as_another_integrator_has_it(changes, laws):
    zero = dict.fromkeys(("c", "t", "d", "k", "q0", "stop", "stop_k", "cogging", "cogs"), 0.0)
    torques = Torques(**(zero | {"scale": 1.0} | laws), wind=np.zeros(1))
    com = LIMB.com
    about = np.diag(LIMB.inertia) + LIMB.mass * (com @ com * np.eye(3) - np.outer(com, com))
    slope = Ball(tuple((LIMB.mass * com).tolist()), about / torques.scale, 9.81, torques).rate()
    state = [*LET_GO.quaternion, *LET_GO.rate]
    time = np.arange(400) / 100.0
    true = solve_ivp(lambda t, s: slope(s.tolist(), (0, 0, 0), 0.0), (0, 4), state, t_eval=time, rtol=1e-10, atol=1e-10)
    truth = swing(replace(PENDULUM, **changes), LET_GO, 4.0, 100.0, step=2e-3)
    # Of order 2 in steps of 2 ms; at half of that it is a quarter.
    assert_allclose(truth.segments[0].rate, true.y[4:].T, atol=5e-4)


def test_dry_friction_stops_a_limb_about_every_axis_and_takes_no_more_than_it_has():
    """d/dt energy = -t |w| while it moves: the law's, not one of each axis by itself."""
    friction = 0.03 * WEIGHT
    truth = swing(replace(PENDULUM, dry_friction=friction), LET_GO, 8.0, 200.0, step=2e-3)
    segment, com = truth.segments[0], LIMB.com
    about = np.diag(LIMB.inertia) + LIMB.mass * (com @ com * np.eye(3) - np.outer(com, com))
    high = LIMB.mass * 9.81 * rotations.rotate(segment.quaternion, com)[:, 2]
    energy = 0.5 * np.sum(segment.rate * (segment.rate @ about), axis=1) + high
    speed = np.linalg.norm(segment.rate, axis=1)
    lost = friction * np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2) / 200.0])
    fast = speed > 0.5  # slower, |w| is rounded over 0.02 rad/s: less than 1e-3 from here on
    assert_allclose((energy[0] - energy)[fast], lost[fast], rtol=5e-3, atol=2e-3 * WEIGHT)
    assert speed[-100:].max() < 0.02


@pytest.mark.parametrize("angle", [0.6, -0.6])
def test_a_stop_on_a_ball_joint_keeps_the_energy_that_it_does_not_damp(angle):
    rig = replace(PENDULUM, stop=Stop(angle, 60.0, 0.0))
    truth = swing(rig, LET_GO, 3.0, 500.0, step=1e-3)
    segment, com = truth.segments[0], LIMB.com
    about = np.diag(LIMB.inertia) + LIMB.mass * (com @ com * np.eye(3) - np.outer(com, com))
    z = rotations.to_matrix(segment.quaternion)[:, :, 2]
    q = np.unwrap(np.arctan2(z[:, 0], z[:, 2]))
    deep = np.maximum(np.sign(angle) * (q - angle), 0.0)
    high = LIMB.mass * 9.81 * rotations.rotate(segment.quaternion, com)[:, 2]
    energy = 0.5 * np.sum(segment.rate * (segment.rate @ about), axis=1) + high + 30.0 * deep**2
    assert deep.max() > 0.05
    assert_allclose(energy, energy[0], atol=5e-3 * WEIGHT)  # of order 2 but where a contact begins


@pytest.mark.parametrize("angle", [0.5, -0.5])
def test_a_hinge_meets_its_stop_as_the_law_has_it(angle):
    stop, mount = Stop(angle, 80.0, 0.03), Mount(np.array([0.1, 0, 0.03]), mass=1e-7)
    turned = rotations.exp(np.array([0.0, np.pi / 2, 0.0]))  # segment 2 hangs at 0
    rig = rigs.hinge(mounts=(mount, mount), base="fixed", base_quaternion=turned, stop=stop)
    own = rig.segments[1]
    inertia, arm = own.inertia[1] + own.mass * own.com[0] ** 2, own.mass * 9.81 * own.com[0]
    side = np.sign(angle)

    def slope(_, state):
        q, w = state
        deep = side * (q - angle)
        pushed = side * max(0.0, 80.0 * deep + 0.03 * side * w) if deep > 0 else 0.0
        return [w, (-arm * np.sin(q) - pushed) / inertia]

    time = np.arange(400) / 200.0
    true = solve_ivp(slope, (0, 2), [-side * 1.2, 0.0], t_eval=time, rtol=1e-9, atol=1e-10, max_step=1e-3)
    truth = swing(rig, Start(angle=-side * 1.2), 2.0, 200.0, step=2e-4)
    assert np.abs(true.y[0]).max() > 1.0 and (side * true.y[0]).max() < 0.7
    # MuJoCo's least impedance leaves 1e-4 of the acceleration, and a step in which a contact begins is of order 1.
    assert_allclose(truth.joint_angle, true.y[0], atol=2e-3)


def test_what_a_rig_cannot_have_is_said():
    with pytest.raises(InputError, match="expected a hinge for coupling, a moving centre or play, got none"):
        rigs.pendulum(coupling=[0.1, 0.0])
    with pytest.raises(InputError, match="expected a joint for drag"):
        rigs.free(drag=0.1)
    with pytest.raises(InputError, match="expected a screw or what a joint does beside turning, got both"):
        rigs.hinge(locked_at=0.3, play=Play(0.01))
    with pytest.raises(InputError, match=r"play\.share: expected a number above 0 and up to 1, got 2"):
        Play(0.01, share=2.0)
