"""A step of the fit turns segment 1 back as its sensor's mount turns: the sensor's own motion stays what it was."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.motion_prior import off_one, prior_rows
from imubench.diagnosis.problem.sensor_axes import left_jacobian, turning, turns_back
from imubench.diagnosis.solve.gauss_newton import all_rows, extended
from imubench.diagnosis.solve.refit import information
from imubench.diagnosis.solve.retract import moved
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.jets import Jet, variable
from imubench.proof.case import make_case


@pytest.fixture(scope="module", params=["pendulum", "hinge", "free"])
def fit(request, tmp_path_factory):
    """A fit of a few seconds, its mount turned by something, and by an effect."""
    folder = tmp_path_factory.mktemp("retraction") / "r"
    make_case(folder, request.param, [], 3, seconds=5.0, rotation_std=0.04)
    h = Hypothesis(EFFECTS["mount_pose"], "imu1")
    return extended(nominal_fit(read(folder)[0]), (h,), {h.key("rotation"): np.array([0.5, 0.1, -0.4])})


def sensed(fit, state):
    """The rate of the first IMU, the force at its segment's origin in the world, and where the IMU points."""
    model, imu = fit.model, fit.model.recording.imus[0]
    moment = model.moment(state, imu.time, imu.name)
    segment = model.segments(state, moment)["segment1"]
    sensor = segment.child(model.mount(imu, state, moment, segment))
    pushed = np.squeeze(segment.turn.matrix @ segment.force.value[:, :, None], axis=2)
    return sensor.rate.value, pushed, sensor.turn.matrix


def along_the_mount(fit, name, turn):
    """A step whose splines follow a turn of the mount (3,) rad to first order, and the state that it leads to."""
    model, state = fit.model, fit.state
    tracks, parameters = model.tracks, model.parameters
    values = np.zeros(sum(len(v) for v in state.values.values()))
    values[parameters.columns(name)] = turn
    small = 1e-6 * turn
    _, slope = turns_back(model.rig, model.mounts, state.values, state.values | {name: state.values[name] + small})
    slope = slope / 1e-6
    change = np.zeros_like(state.coefficients)
    q = state.coefficients[:, tracks.columns("attitude")]
    w, v = q[:, :1], q[:, 1:]
    change[:, tracks.columns("attitude")] = 0.5 * np.hstack([-v @ slope[:, None], w * slope + np.cross(v, slope)])
    for vector in tracks.widths.keys() & {"force", "velocity"}:
        change[:, tracks.columns(vector)] = -np.cross(slope, state.coefficients[:, tracks.columns(vector)])
    return moved(model, state, change, values)


@pytest.mark.parametrize("name", turning("imu1"))
def test_a_mount_turned_far_leaves_what_its_sensor_does(fit, name):
    turn = np.array([0.2, -0.3, 0.25])
    new = along_the_mount(fit, name, turn)
    assert np.allclose(new.values[name], fit.state.values[name] + turn)
    (rate, force, points), (rate0, force0, points0) = sensed(fit, new), sensed(fit, fit.state)
    assert np.allclose(points, points0, atol=1e-9)
    assert np.allclose(rate, rate0, atol=1e-9 * np.abs(rate0).max())
    assert np.allclose(force, force0, atol=1e-9 * np.abs(force0).max())


@pytest.mark.parametrize("name", turning("imu1"))
def test_priors_of_the_motion_know_nothing_of_the_mount(fit, name):
    """They cost the same however far it turns, and their rows do not move: no false knowledge of it."""
    turn = np.array([0.1, -0.2, 0.15])
    told = ("smooth.", "pace", "drift")
    new = along_the_mount(fit, name, turn)
    before, after = (
        {r.name: r.residual.value / r.std for r in prior_rows(fit.model, state, fit.noise, fit.anchor)}
        for state in (fit.state, new)
    )
    some = [key for key in before if key.startswith(told) and not key.startswith("smooth.hinge")]
    assert some
    for key in some:
        assert np.allclose(after[key], before[key], atol=1e-6 * np.abs(before[key]).max()), key


def test_a_turn_of_the_mount_that_nothing_sees_stays_as_unknown_as_it_was(tmp_path):
    """Where no encoder is, about the hinge: of its own prior 0.5 rad, and what its position, which turns too, adds."""
    make_case(tmp_path / "r", "hinge", [], 4, seconds=5.0)
    h = Hypothesis(EFFECTS["mount_pose"], "imu1")
    fit = extended(nominal_fit(read(tmp_path / "r")[0]), (h,))
    model = fit.model
    covariance, _ = information(replace(fit, rows=all_rows(model, fit.state, fit.noise, fit.anchor)))
    mount, axis = model.mounts["imu1"], np.array([0.0, 1.0, 0.0])
    turn = np.concatenate([mount.turn.T @ axis, np.cross(axis, mount.position)])
    at = model.parameters.places([h.key("rotation"), h.key("translation")])
    prior = np.concatenate([model.priors[h.key(k)].std for k in ("rotation", "translation")])
    expected = 1 / np.sum((turn / prior) ** 2)
    along = turn / (turn @ turn)
    assert along @ covariance[np.ix_(at, at)] @ along == pytest.approx(expected, rel=0.1)


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


def test_an_attitude_s_norm_is_held_at_one_and_away_from_nought():
    """As close to one as n - 1 holds it, without end towards nought; slopes by central differences."""
    n = np.geomspace(1e-4, 9.0, 50)[:, None]
    held = off_one(variable(("n", 0), n))
    step = 1e-6 * n
    slope = (off_one(Jet(n + step)).value - off_one(Jet(n - step)).value) / (2 * step)
    assert held.blocks["n", 0][:, :, 0] == pytest.approx(slope, rel=1e-6)
    near = np.array([[0.98], [1.0], [1.02]])
    assert off_one(Jet(near)).value == pytest.approx(near - 1, abs=3e-4)  # less half of its square
    assert off_one(Jet(np.array([[1e-4]]))).value < -4999
