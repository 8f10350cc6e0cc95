"""Sprung mounts: consistent with their own position, and with an independent integration of their equations."""

from dataclasses import fields, replace

import numpy as np
import pytest
from mujoco import batch as mujoco_batch
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from imubench import rotations
from imubench.errors import InputError
from imubench.sim import rigs
from imubench.sim.compile import DRIVEN_ARMATURE, compile_model, mount_dofs
from imubench.sim.driven import evaluate, joint_state
from imubench.sim.felt import read_mounts
from imubench.sim.jolt import jolted
from imubench.sim.kinematics import segments_of
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.readout import read_truth
from imubench.sim.rigs import Mount, Spring, springs
from imubench.sim.signals import Sines
from imubench.sim.sprung import sprung_motion

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


def converging(rig: rigs.Rig, motion: AngleMotion, solve, of: str, steps: tuple[float | None, ...]) -> list[float]:
    """Return the greatest errors at 0.9 s, over the size, of steps in s; None: the default."""
    x, v, _ = sprung_motion(rig, compile_model(rig, driven="joints"), motion, 1, 100.0)
    expected = solve(x[0], v[0])
    played = (play(rig, motion, 1.0, 100.0, step=h).sensors[1] for h in steps)
    return [float(np.abs(getattr(sensor, of)[90] - expected).max() / np.abs(expected).max()) for sensor in played]


@pytest.mark.parametrize(("damping", "longest", "bound"), [(0.0, 5e-3, 1e-4), (0.15, 5e-3, 4e-5), (3.0, 5e-3, 5e-6)])
def test_sliding_mount_converges_to_an_independent_integration(damping, longest, bound, random_motion, jets):
    """Of order 4: half the step leaves a sixteenth of the error; 5 ms are an eighteenth of the fastest period.

    A leapfrog with 200 steps of the fastest period was off by 2e-3 without dampers and by 8e-4 with 0.15.
    """
    spring, motion = springs(np.array([7.0, 9.0, 11.0]), damping), random_motion(6)

    def solve(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return displacement_by_ode(motion, jets, spring, 0.9, x, v)

    steps = longest, longest / 2, longest / 4, None
    errors = converging(sprung_hinge(translation=spring), motion, solve, "displacement", steps)
    assert errors[0] / errors[1] > 12.0
    assert errors[1] / errors[2] > 12.0
    assert errors[3] < bound  # measured: 3e-5, and with dampers 1e-7 to 2e-5 on eight motions


def rocking_by_ode(motion: AngleMotion, jets, mount: Mount, duration: float, start: np.ndarray) -> np.ndarray:
    """Moments about the moving pivot, whatever the angles; w the sensor's rate, t the joint angles about x, y, z:

    k^2 w' + c x (Rs^T (pivot'' - g)) = tau,  Rs = R Rm Rx(t1) Ry(t2) Rz(t3),  E^T tau = -k^2 (W^2 t + 2 Z W t'),
    w = Rs^T (rate of the segment) + E t'.
    """
    spring, k2, c = mount.rotation, mount.gyration**2, mount.com
    W, Z = 2 * np.pi * spring.frequency, spring.damping_ratio
    Rm = rotations.to_matrix(mount.quaternion)
    pivot = mount.position - Rm @ mount.lever

    def frames(t: float, angles: np.ndarray) -> tuple[np.ndarray, ...]:
        rig = jets(motion, np.array([t]))
        R, dR, ddR = (m[0] for m in rig.R2)
        spin = R.T @ dR
        Rx, Ry, Rz = (rotations.to_matrix(rotations.exp(v)) for v in np.diag(angles))
        E = np.stack([(Ry @ Rz).T[:, 0], Rz.T[:, 1], [0, 0, 1]], axis=1)
        inner = Rm @ Rx @ Ry @ Rz
        force = (R @ inner).T @ (rig.p[2][0] + ddR @ pivot + np.array([0, 0, 9.81]))
        return inner.T @ np.array([spin[2, 1], spin[0, 2], spin[1, 0]]), E, force

    def slope(t: float, state: np.ndarray) -> np.ndarray:
        angles, w = state[:3], state[3:]
        carried, E, force = frames(t, angles)
        rates = np.linalg.solve(E, w - carried)
        torque = np.linalg.solve(E.T, -(W**2) * angles - 2 * Z * W * rates)
        return np.concatenate([rates, torque - np.cross(c, force) / k2])

    found = solve_ivp(slope, (0, duration), start, rtol=1e-9, atol=1e-11, method="DOP853")
    return found.y[3:, -1]


@pytest.mark.parametrize(("damping", "bound"), [(0.02, 2e-4), (0.15, 8e-5)])
def test_rocking_mount_converges_to_an_independent_integration(damping, bound, random_motion, jets):
    """What a gyroscope reads, the whole rate: joint angles enter through it. Order 4, as above.

    A leapfrog with 200 steps of the fastest period was off by 3e-4 and 1e-4.
    """
    spring, motion = springs(np.array([7.0, 9.0, 11.0]), damping), random_motion(6)
    rig = sprung_hinge(rotation=spring, com=np.array([0.003, -0.002, 0.004]), lever=np.array([0.0, 0.01, 0.02]))

    def solve(angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
        gyro = play(rig, motion, 0.01, 100.0).sensors[1].gyro[0]
        return rocking_by_ode(motion, jets, rig.mounts[1], 0.9, np.concatenate([angles, gyro]))

    errors = converging(rig, motion, solve, "gyro", (5e-3, 2.5e-3, 1.25e-3, None))
    assert errors[0] / errors[1] > 12.0
    assert errors[1] / errors[2] > 12.0
    assert errors[3] < bound  # measured: 1e-4 and 4e-5


SPRUNG = {
    "sliding": {"translation": springs([7.0, 9.0, 11.0], 0.1), "com": np.array([0.001, 0.002, -0.001])},
    "rocking": {"rotation": springs([20.0, 15.0, 12.0], 0.1), "com": np.array([0.003, 0.001, 0.004])},
    "both": {"translation": springs(8.0, 0.1), "rotation": springs(20.0, 0.1), "com": np.array([0.003, 0.0, 0.004])},
}


@pytest.mark.parametrize("kind", SPRUNG)
@pytest.mark.parametrize("base", ["free", "fixed"])
def test_jolt_is_what_mujoco_does_in_a_nanosecond(kind, base, random_motion):
    lever = {} if kind == "sliding" else {"lever": np.array([0.0, 0.01, 0.02])}
    rig = replace(sprung_hinge(**SPRUNG[kind], **lever), base=base)
    model, told = compile_model(rig, integrator="Euler", driven="joints"), random_motion(8)(np.linspace(0.0, 1.0, 20))
    model.opt.timestep, model.jnt_stiffness[:], model.dof_damping[:] = 1e-9, 0.0, 0.0
    dofs, rng = mount_dofs(model), np.random.default_rng(0)
    x, v = (scale * rng.standard_normal((20, int(dofs.sum()))) for scale in (0.2, 1.0))
    jump = replace(told, velocity=told.position, rate=told.velocity, angle_rate=told.angle)  # any numbers of 1 will do
    qpos, qvel, _ = joint_state(rig, model, told, (x, v))
    force = DRIVEN_ARMATURE * np.where(dofs, 0.0, joint_state(rig, model, jump)[1]) / 1e-9
    batch = mujoco_batch.Batch(model, nsim=20)
    batch.bind("qpos")[:], batch.bind("qvel")[:], batch.bind("qfrc_applied")[:] = qpos, qvel, force
    batch.step()
    found = jolted(rig.mounts[1], segments_of(rig, jump)[1], x, v)
    # Gravity and centripetal terms of 100 rad/s^2 change rates by 1e-7 rad/s within the nanosecond.
    assert_allclose(found, batch.bind("qvel")[:, dofs], atol=5e-7)


@pytest.mark.parametrize("kind", SPRUNG)
@pytest.mark.parametrize("changes", [{}, {"base": "fixed"}, {"locked_at": 0.4}])
def test_mounts_are_read_as_mujocos_own_sensors_read_them(kind, changes, random_motion):
    rig = replace(sprung_hinge(**SPRUNG[kind], lever=np.array([0.0, 0.01, 0.02])), **changes)
    model, told, rng = (
        compile_model(rig, driven="joints"),
        random_motion(9)(np.linspace(0.0, 4.0, 40)),
        np.random.default_rng(1),
    )
    x, v = (scale * rng.standard_normal((40, int(mount_dofs(model).sum()))) for scale in (0.2, 3.0))
    data = evaluate(model, *joint_state(rig, model, told, (x, v)))
    expected = read_truth(rig, model, told.time, data, played=told)
    for found, sensor in zip(read_mounts(rig, expected.segments, x, v), expected.sensors, strict=True):
        for key in (f.name for f in fields(sensor) if f.name != "name"):
            # Driven joints give way by 1e-13 of the forces on them, beside springs' accelerations of up to 1e4 rad/s^2.
            want = getattr(sensor, key)
            assert_allclose(getattr(found, key), want, rtol=1e-9, atol=1e-9 * max(1.0, np.abs(want).max()), err_msg=key)


def test_springs_that_do_not_hold_the_sensor_are_refused():
    shaken = AngleMotion(spin=Sines(1.0, 5.0))
    with pytest.raises(InputError, match=r"sprung mount: expected springs that hold the sensor within 1\.4 rad, got"):
        play(sprung_hinge(rotation=springs(5.0, 0.02)), shaken, 4.0, 100.0)


@pytest.mark.parametrize(("frequency", "damping"), [(10.0, 1e7), (1e5, 0.1)])
def test_springs_too_quick_to_integrate_are_refused_before_they_take_time_or_memory(frequency, damping):
    quick = springs(frequency, damping)
    with pytest.raises(
        InputError, match=r"expected springs and dampers that are integrated in steps of 1e-05 s or more"
    ):
        play(sprung_hinge(rotation=quick), AngleMotion(spin=Sines(1.0, 0.5)), 1.0, 50.0)


def test_a_recording_of_one_sample_is_at_rest_on_its_springs(random_motion):
    rig = sprung_hinge(translation=springs(8.0, 0.1), rotation=springs(20.0, 0.1))
    one, many = (play(rig, random_motion(3), seconds, 100.0).sensors[1] for seconds in (0.01, 1.0))
    # The step is the same, so the rates at the start differ by rounding alone.
    assert_allclose(one.displacement[0], many.displacement[0], atol=1e-15)
    assert_allclose(one.gyro[0], many.gyro[0], rtol=1e-9)


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
