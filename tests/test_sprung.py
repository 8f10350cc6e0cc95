"""Sprung mounts: consistent with their own position, and with an independent integration of their equations."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from imubench import rotations
from imubench.sim import rigs
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.rigs import Mount, Spring, springs

POSITION = np.array([0.1, 0.02, 0.03])


def sprung_hinge(**springs: object) -> rigs.Rig:
    q = rotations.exp(np.array([0.4, -1.0, 0.3]))
    return rigs.hinge(mounts=(Mount(np.array([-0.1, 0, 0.03])), Mount(POSITION, q, **springs)))


def test_accelerometer_is_the_second_derivative_of_the_true_position(random_motion):
    """At every halving of the step the differences' own error, h^2, falls to a quarter."""
    rig = sprung_hinge(
        translation=springs(np.array([8.0, 10.0, 12.0]), 0.2),
        rotation=springs(9.0, 0.1),
        lever=np.array([0.0, 0.01, 0.02]),
    )
    errors = []
    for h in (2e-3, 1e-3, 5e-4):
        sensor = play(rig, random_motion(4), 4.0, 1 / h, step=h).sensors[1]
        second = np.diff(sensor.position, 2, axis=0) / h**2
        late = slice(round(1.0 / h), None)  # the start's transient holds higher frequencies
        errors.append(np.abs(second - sensor.acceleration[1:-1])[late].max())
        assert np.abs(sensor.displacement).max() > 2e-3
        assert np.abs(sensor.rotation).max() > 0.02
        force = rotations.rotate_back(sensor.quaternion, sensor.acceleration + np.array([0, 0, 9.81]))
        assert_allclose(sensor.specific_force, force, atol=1e-9)
    assert errors[2] < 1e-3
    assert 3.0 < errors[0] / errors[1] < 5.0
    assert 3.0 < errors[1] / errors[2] < 5.0


def displacement_by_ode(
    motion: AngleMotion, jets, spring: Spring, duration: float, start: np.ndarray, speed: np.ndarray
) -> np.ndarray:
    """Newton in the turning segment frame, x the displacement in it:

    x'' = R^T (g - p'') - w' x s - w x (w x s) - 2 w x x' - W^2 x - 2 Z W x',  s = mount + x.
    """
    w0, zeta = 2 * np.pi * spring.frequency, spring.damping_ratio

    def slope(t: float, state: np.ndarray) -> np.ndarray:
        rig = jets(motion, np.array([t]))
        R, dR, ddR = (m[0] for m in rig.R2)
        x, v = state[:3], state[3:]
        s = POSITION + x
        inertial = R.T @ (np.array([0, 0, -9.81]) - rig.p[2][0] - ddR @ s - 2 * dR @ v)
        return np.concatenate([v, inertial - w0**2 * x - 2 * zeta * w0 * v])

    found = solve_ivp(slope, (0, duration), np.concatenate([start, speed]), rtol=1e-9, atol=1e-11, method="DOP853")
    return found.y[:3, -1]


@pytest.mark.parametrize("damping", [0.0, 0.15])
def test_sprung_mount_converges_to_an_independent_integration(damping, random_motion, jets):
    """Of first order: velocities in dampers and inertial forces lag by half a step."""
    spring = springs(np.array([7.0, 9.0, 11.0]), damping)
    motion, errors = random_motion(6), []
    fine = play(sprung_hinge(translation=spring), motion, 1.0, 1000.0, step=1e-5).sensors[1].displacement
    speed = np.array([-25 / 12, 4, -3, 4 / 3, -1 / 4]) @ fine[:5] / 1e-3
    expected = displacement_by_ode(motion, jets, spring, 0.9, fine[0], speed)
    for h in (1e-3, 5e-4, 2.5e-4):
        errors.append(
            np.abs(
                play(sprung_hinge(translation=spring), motion, 1.0, 1000.0, step=h).sensors[1].displacement[900]
                - expected
            ).max()
        )
    assert errors[-1] < 2e-3 * np.abs(expected).max()
    assert 3.5 < errors[0] / errors[2] < 5.0  # a quarter of the step, a quarter of the error
    assert errors[0] < 5e-3 * np.abs(expected).max()


def test_rocking_mount_obeys_its_linear_equation(random_motion):
    """theta'' + 2 z w theta' + w^2 theta = -alpha + com x (-f) / gyration^2, to first order in theta."""
    spring, com, h = springs(20.0, 0.3), np.array([0.003, 0.0, 0.004]), 1e-3
    rig = sprung_hinge(rotation=spring, com=com)
    rigid = play(sprung_hinge(), random_motion(5), 4.0, 1 / h).sensors[1]
    rocked = play(rig, random_motion(5), 4.0, 1 / h, step=5e-5).sensors[1]
    drive = -rigid.angular_acceleration + np.cross(com, -rigid.specific_force) / 0.015**2
    w = 2 * np.pi * 20.0
    theta = rocked.rotation
    left = (
        np.gradient(np.gradient(theta, h, axis=0), h, axis=0) + 0.6 * w * np.gradient(theta, h, axis=0) + w**2 * theta
    )
    late = slice(1000, -10)
    # Terms of second order: theta (0.03 rad) times rates and forces leaves a few per cent of the drive.
    assert np.sqrt(np.mean((left - drive)[late] ** 2)) < 0.05 * np.sqrt(np.mean(drive[late] ** 2))


def test_sag_is_a_part_of_the_effect():
    sensor = play(sprung_hinge(translation=springs(10.0, 0.5)), AngleMotion(), 0.5).sensors[1]
    assert_allclose(sensor.displacement[:, 2], -9.81 / (2 * np.pi * 10.0) ** 2, rtol=1e-6)


def test_stiff_springs_are_a_rigid_mount(random_motion):
    rigid, stiff = (
        play(sprung_hinge(**s), random_motion(2), 1.0).sensors[1] for s in ({}, {"translation": springs(300.0, 0.7)})
    )
    # The sag under 15 m/s^2 is 15 / (2 pi 300)^2 = 4 um; its acceleration is that times (2 pi 3 Hz)^2.
    assert_allclose(stiff.specific_force[100:], rigid.specific_force[100:], atol=0.05)
    assert np.abs(stiff.displacement).max() < 2e-5
