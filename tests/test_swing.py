"""Forward dynamics against energy, decay laws and closed forms."""

import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench import rotations
from imubench.errors import InputError
from imubench.sim import rigs
from imubench.sim.swing import Start, swing, swing_many

DOWN = rotations.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.pi / 2)  # segment 2 hangs at hinge angle 0


def energy(rig: rigs.Rig, truth) -> np.ndarray:
    """Kinetic and potential energy of segments and IMUs (IMUs have their centre of mass in the sensor)."""
    total = np.zeros(truth.time.size)
    for segment, body in zip(rig.segments, truth.segments, strict=True):
        com = body.position + rotations.rotate(body.quaternion, segment.com)
        speed = body.velocity + rotations.rotate(body.quaternion, np.cross(body.rate, segment.com))
        total += 0.5 * segment.mass * (speed**2).sum(axis=1) + 0.5 * body.rate**2 @ segment.inertia
        total += segment.mass * rig.gravity * com[:, 2]
    for mount, body, sensor in zip(rig.mounts, truth.segments, truth.sensors, strict=True):
        speed = body.velocity + rotations.rotate(body.quaternion, np.cross(body.rate, mount.position))
        total += 0.5 * mount.mass * ((speed**2).sum(axis=1) + mount.gyration**2 * (sensor.gyro**2).sum(axis=1))
        total += mount.mass * rig.gravity * sensor.position[:, 2]
    return total


@pytest.mark.parametrize(
    ("rig", "start"),
    [
        (rigs.hinge(base="fixed", base_quaternion=DOWN), Start(angle=2.0)),
        (rigs.pendulum(), Start(quaternion=rotations.exp(np.array([0.9, 0.3, 0.0])), rate=np.array([0.0, 1.0, 2.0]))),
    ],
    ids=["hinge", "pendulum"],
)
def test_energy_is_kept_in_a_frictionless_swing(rig, start):
    total = energy(rig, swing(rig, start, 20.0))
    kinetic_range = 0.5  # J, about what goes to and fro
    assert np.ptp(total) < 1e-8 * kinetic_range  # Runge-Kutta of order 4 at 1 ms over 20 s


def test_small_swing_has_the_period_of_the_physical_pendulum():
    rig = rigs.hinge(base="fixed", base_quaternion=DOWN)
    segment, mount = rig.segments[1], rig.mounts[1]
    inertia = segment.inertia[1] + segment.mass * segment.com @ segment.com
    inertia += mount.mass * (mount.gyration**2 + mount.position @ mount.position)
    lever = segment.mass * segment.com + mount.mass * mount.position
    w = np.sqrt(9.81 * np.linalg.norm(lever) / inertia)
    rest = -np.arctan2(lever[2], lever[0])  # angle from the equilibrium: the IMU sits off the segment's axis
    truth = swing(rig, Start(angle=rest * -1 + 1e-3), 5.0)
    assert_allclose(truth.joint_angle, -rest + 1e-3 * np.cos(w * truth.time), atol=1e-8)  # theta^3 / 6


def test_viscous_and_dry_friction_decay_as_their_laws_say():
    """Far from gravity, c alone decays exponentially and t alone linearly."""

    def rate_after(seconds: float, **friction: float) -> np.ndarray:
        rig = rigs.hinge(base="fixed", gravity=0.0, **friction)
        return swing(rig, Start(angle_rate=2.0), seconds).joint_rate

    rig = rigs.hinge()
    segment, mount = rig.segments[1], rig.mounts[1]
    inertia = segment.inertia[1] + segment.mass * segment.com @ segment.com
    inertia += mount.mass * (mount.gyration**2 + mount.position[[0, 2]] @ mount.position[[0, 2]])
    time = np.arange(2000) / 1000
    assert_allclose(rate_after(2.0, damping=2e-3), 2.0 * np.exp(-2e-3 / inertia * time), rtol=1e-8)
    # MuJoCo's friction is a soft constraint: it lets the joint creep by about 1 % of the loss of rate.
    assert_allclose(rate_after(2.0, dry_friction=1e-3), 2.0 - 1e-3 / inertia * time, atol=0.02)


def test_torque_gives_torque_over_inertia():
    rig = rigs.hinge(base="fixed", gravity=0.0)
    truth = swing(rig, Start(), 1.0, torque=lambda t: np.full(t.shape, 0.01))
    reference = swing(rig, Start(), 1.0, torque=lambda t: np.full(t.shape, 0.02))
    assert_allclose(2 * truth.joint_rate, reference.joint_rate, rtol=1e-9, atol=1e-12)
    assert truth.joint_rate[-1] > 0.5


def test_a_screw_leaves_no_relative_motion():
    truth = swing(rigs.hinge(locked_at=0.3), Start(rate=np.array([1.0, 2.0, 3.0])), 1.0)
    assert_allclose(truth.joint_angle, 0.3, atol=1e-12)
    assert_allclose(truth.joint_rate, 0.0, atol=1e-12)


def test_accelerometer_of_a_swing_is_the_second_derivative_of_its_position():
    h = 1e-3
    sensor = swing(rigs.hinge(base="fixed", base_quaternion=DOWN), Start(angle=1.0), 2.0).sensors[1]
    assert_allclose(np.diff(sensor.position, 2, axis=0) / h**2, sensor.acceleration[1:-1], atol=2e-3)  # h^2/12 x''''


def test_many_rigs_are_the_same_as_one_by_one():
    rng = np.random.default_rng(0)
    several = [rigs.random_hinge(rng, base="fixed") for _ in range(20)]
    starts = [Start(angle=float(rng.uniform(-1, 1))) for _ in several]
    for rig, start, truth in zip(several, starts, swing_many(several, starts, 0.2), strict=True):
        alone = swing(rig, start, 0.2)
        assert np.array_equal(alone.sensors[1].specific_force, truth.sensors[1].specific_force)


def test_rigs_that_differ_in_structure_are_refused():
    with pytest.raises(InputError, match="differ in numbers only"):
        list(swing_many([rigs.hinge(), rigs.hinge(locked_at=0.1)], [Start(), Start()], 0.1))


def test_a_sprung_sensor_swings_along():
    soft = rigs.Mount(np.array([0.1, 0, 0.03]), translation=rigs.springs(10.0, 0.3))
    rig = rigs.hinge(base="fixed", base_quaternion=DOWN, mounts=(rigs.hinge().mounts[0], soft))
    truth = swing(rig, Start(angle=1.0), 2.0, step=2e-4)
    assert 1e-3 < np.abs(truth.sensors[1].displacement).max() < 2e-2


def test_a_swing_that_runs_away_ends_in_one_line_and_without_a_log(tmp_path):
    """It used to repeat its last state for the rest of the record, and MuJoCo left MUJOCO_LOG.TXT and a warning."""
    code = (
        "from imubench.sim.rigs import hinge\n"
        "from imubench.sim.swing import Start, swing\n"
        "swing(hinge(stiffness=1e7), Start(angle=1.0), 1.0)\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ended.stderr.splitlines()[-1] == (
        "imubench.errors.InputError: swing: expected a simulation that stays finite, got one that does not: "
        "a spring, damper or torque is too strong for the time step"
    )
    assert "WARNING" not in ended.stderr + ended.stdout
    assert not list(tmp_path.iterdir())
