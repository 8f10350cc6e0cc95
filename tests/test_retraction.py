"""A step of the fit turns segment 1 back as its sensor's mount turns: the sensor's own motion stays what it was."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imubench.diagnosis.fit import MOUNT, left_jacobian, moved
from imubench.diagnosis.nominal import nominal_fit
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.fixture(scope="module", params=["pendulum", "hinge", "free"])
def fit(request, tmp_path_factory):
    """A fit of a few seconds, its mount turned by something."""
    folder = tmp_path_factory.mktemp("retraction") / "r"
    make_case(folder, request.param, [], 3, seconds=5.0, rotation_std=0.04)
    return nominal_fit(read(folder)[0])


def sensed(fit, state):
    """The rate of the first IMU, the force at its segment's origin in the world, and where the IMU points."""
    model, imu = fit.model, fit.model.recording.imus[0]
    moment = model.moment(state, imu.time, imu.name)
    segment = model.segments(state, moment)["segment1"]
    sensor = segment.child(model.mount(imu, state, moment, segment))
    pushed = np.squeeze(segment.turn.matrix @ segment.force.value[:, :, None], axis=2)
    return sensor.rate.value, pushed, sensor.turn.matrix


def along_the_mount(fit, turn):
    """A step whose splines follow a turn of the mount (3,) rad to first order, and the state that it leads to."""
    model, state = fit.model, fit.state
    tracks, parameters = model.tracks, model.parameters
    values = np.zeros(sum(len(v) for v in state.values.values()))
    values[parameters.columns(MOUNT)] = turn
    slope = -model.mounts["imu1"].turn @ left_jacobian(state.values[MOUNT]) @ turn
    change = np.zeros_like(state.coefficients)
    q = state.coefficients[:, tracks.columns("attitude")]
    w, v = q[:, :1], q[:, 1:]
    change[:, tracks.columns("attitude")] = 0.5 * np.hstack([-v @ slope[:, None], w * slope + np.cross(v, slope)])
    if "force" in tracks.widths:
        change[:, tracks.columns("force")] = -np.cross(slope, state.coefficients[:, tracks.columns("force")])
    return moved(model, state, change, values)


def test_a_mount_turned_far_leaves_what_its_sensor_does(fit):
    turn = np.array([0.2, -0.3, 0.25])
    new = along_the_mount(fit, turn)
    assert np.allclose(new.values[MOUNT], fit.state.values[MOUNT] + turn)
    (rate, force, points), (rate0, force0, points0) = sensed(fit, new), sensed(fit, fit.state)
    assert np.allclose(points, points0, atol=1e-9)
    assert np.allclose(rate, rate0, atol=1e-9 * np.abs(rate0).max())
    assert np.allclose(force, force0, atol=1e-9 * np.abs(force0).max())


def test_small_steps_are_the_straight_ones(fit):
    rng = np.random.default_rng(0)
    change = rng.standard_normal(fit.state.coefficients.shape)
    values = rng.standard_normal(sum(len(v) for v in fit.state.values.values()))
    off = []
    for size in (1e-3, 1e-4):
        new = moved(fit.model, fit.state, size * change, size * values)
        straight = fit.state.coefficients + size * change
        off.append(np.abs(new.coefficients - straight).max())
    assert off[1] < 0.02 * off[0]  # of second order


@pytest.mark.parametrize("size", [0.0, 1e-8, 0.3, 2.0])
def test_the_left_jacobian_is_that_of_the_exponential(size):
    rng = np.random.default_rng(1)
    r = size * rng.standard_normal(3)
    h = 1e-6
    for d in np.eye(3):
        ahead, behind = (Rotation.from_rotvec(r + s * h * d) for s in (1, -1))
        by_hand = (ahead * behind.inv()).as_rotvec() / (2 * h)
        assert np.allclose(left_jacobian(r) @ d, by_hand, atol=1e-7)
