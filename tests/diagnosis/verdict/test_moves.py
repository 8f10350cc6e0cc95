"""What a finding moves: held against the truth's own geometry, fits from scratch, and recordings without the effect."""

from dataclasses import replace

import numpy as np
import pytest

from imubench import rotations
from imubench.diagnosis.noise.nominal import first_fit, nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks.ordinary_estimates import OrdinaryEstimates
from imubench.diagnosis.result import TOLERANCE, UNKNOWN, Finding, Interval, Parameter, is_material
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.solve.initialize import model_of
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.verdict.estimate_shift import estimates_of, moves_between, times, turned
from imubench.diagnosis.verdict.without_finding import fit_without, moves_of, moves_of_all, shifts_of
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

SHORT = {"seconds": 6.0, "rate": 50.0, "band": 1.9, "vigour": 1.5}
TRUE_MOUNTS = {"geometry_error": False, "rotation_std": 0.002, "position_std": 0.001}
NONE = Interval(0.0, (0.0, 0.0))
DEG = np.pi / 180


def said(effect, at, **parameters):
    return Finding(effect, at, 0.9, parameters, NONE)


def recorded(folder, *effects, rig="hinge", seed=5, **options):
    make_case(folder, rig, effects=list(effects), seed=seed, **(SHORT | options))
    return read(folder)[0]


def fitted(recording, *effects):
    """The recording's fit with some effects (name, at) in its model."""
    hypotheses = tuple(Hypothesis(EFFECTS[name], at) for name, at in effects)
    fit = nominal_fit(recording, check_samples(recording).masks)
    return with_noise(refit(fit, hypotheses, steps=12)) if hypotheses else fit


def moves(fit, finding, recording):
    ((_, known),) = moves_of([finding], fit, check_samples(recording), recording)
    return known


def shifts(fit, finding, recording):
    ((_, known),) = shifts_of([finding], fit, check_samples(recording), recording)
    return known


@pytest.mark.parametrize(("rotation", "material"), [((0, 0, 3), True), ((3, 0, 0), True), ((0, 0, 0.2), False)])
def test_a_turned_mount_moves_axis_and_centre_as_its_rotation_does(rotation, material, tmp_path):
    """By the truth's numbers alone: x in the sensor's axes becomes exp(-rotation) x.

    Within 0.15 deg: the mounts are known to 0.002 rad, 0.11 deg, which is not the mount's error, and within 1 mm, that
    for 0.4 mm of the rotation along the hinge.
    """
    rotation = np.array(rotation) * DEG
    given = {"rotation": rotation.tolist(), "translation": [0.0, 0.0, 0.0]}
    recording = recorded(tmp_path / "r", ("mount_pose", "imu2", given), **TRUE_MOUNTS)
    imu = recording.imu("imu2")
    nominal = rotations.to_matrix(imu.mount_quaternion)
    turn = rotations.to_matrix(rotations.exp(rotation))
    axis, centre = nominal.T @ [0.0, 1.0, 0.0], -nominal.T @ imu.mount_position
    angle = np.degrees(np.arccos(axis @ turn @ axis))
    off = 1e3 * np.linalg.norm(np.cross(turn.T @ axis, turn.T @ centre - centre))  # any point on the axis is a centre

    fit, finding = fitted(recording, ("mount_pose", "imu2")), said("mount_pose", "imu2")
    known = shifts(fit, finding, recording)
    assert known["joint_axis"].value == pytest.approx([0.0, angle], abs=0.15)
    assert known["joint_centre"].value == pytest.approx([0.0, off], abs=1.0)
    assert is_material(moves(fit, finding, recording), TOLERANCE) is material


def test_two_findings_together_move_what_either_does(tmp_path):
    """Turned by 3 deg about z the mount moves the hinge's axis by that, as above; both turn what a filter says."""
    turned_mount = {"rotation": [0.0, 0.0, 3 * DEG], "translation": [0.0, 0.0, 0.0]}
    bias = {"bias": [0.0, 0.03, 0.0]}
    recording = recorded(
        tmp_path / "r", ("mount_pose", "imu2", turned_mount), ("gyro_bias", "imu2", bias), **TRUE_MOUNTS
    )
    imu = recording.imu("imu2")
    nominal = rotations.to_matrix(imu.mount_quaternion)
    axis = nominal.T @ [0.0, 1.0, 0.0]
    angle = np.degrees(np.arccos(axis @ rotations.to_matrix(rotations.exp(np.array([0.0, 0.0, 3 * DEG]))) @ axis))
    both = fitted(recording, ("mount_pose", "imu2"), ("gyro_bias", "imu2"))
    known = moves_of_all(both, recording, TOLERANCE)
    assert known["joint_axis"].value == pytest.approx([0.0, angle], abs=0.3)  # twice as many numbers to take it up
    filtered = OrdinaryEstimates.of(both)
    every = both.model.hypotheses
    mount, bias, together = (filtered.shift(some)["orientation"][1] for some in (every[:1], every[1:], every))
    assert mount > 0.5 and bias > 0.5
    assert abs(mount - bias) <= together <= mount + bias
    assert known["orientation"].value == pytest.approx(filtered.farther_off(every)["orientation"].value)


def test_nothing_found_moves_nothing(clean):
    recording, fit = clean
    assert moves_of_all(fit, recording, TOLERANCE) == {}


def test_a_gyroscopes_bias_moves_what_a_fit_from_scratch_without_it_says_otherwise(tmp_path):
    """Four steps from the fit with it lead to where a fit that never knew of it ends, at the same noise.

    Within a tenth, of which nothing hangs, and 0.02 deg: each ends where a step gains 1e-4 of the cost a number.
    """
    recording = recorded(tmp_path / "r", ("gyro_bias", "imu2", {"bias": [0.01, 0.03, -0.01]}))
    fit, naive = fitted(recording, ("gyro_bias", "imu2")), fitted(recording)
    known = shifts(fit, said("gyro_bias", "imu2"), recording)
    stamps = times(fit)
    naive = solve(naive.model, naive.state, {name: fit.noise[name] for name in naive.noise}, naive.anchor)
    scratch = moves_between(estimates_of(fit, stamps), estimates_of(naive, stamps), recording)
    for name in ("joint_axis", "hinge_angle", "orientation"):
        assert known[name].value == pytest.approx(scratch[name].value, rel=0.1, abs=0.02), name
    assert is_material(moves(fit, said("gyro_bias", "imu2"), recording), TOLERANCE)


def test_a_bias_that_every_gyroscope_has_is_immaterial(tmp_path):
    recording = recorded(tmp_path / "r", ("gyro_bias", "imu2", {"bias": [0.001, 0.001, -0.001]}))
    known = moves(fitted(recording, ("gyro_bias", "imu2")), said("gyro_bias", "imu2"), recording)
    assert known and not is_material(known, TOLERANCE)


def test_rounding_moves_as_much_as_the_same_recording_without_it_says(tmp_path):
    """The rounding's errors are estimated where the noise is a part of a step, so most of what they move is found.

    Not all: within a factor of two.
    """
    step = 0.05  # rad/s: 25 times the noise
    effect = ("quantisation", "imu2", {"step": step, "channels": ["gyro"]})
    rounded = recorded(tmp_path / "rounded", effect)
    plain = recorded(tmp_path / "plain")
    coarse = fitted(rounded)
    fine = solve(replace(coarse.model, recording=plain), coarse.state, coarse.noise, coarse.anchor)
    finding = said("quantisation", "imu2", step=Parameter(step, 1e-6, "rad/s"))
    known = shifts(coarse, finding, rounded)
    truth = moves_between(estimates_of(coarse, times(coarse)), estimates_of(fine, times(coarse)), rounded)
    for name in ("hinge_angle", "orientation"):
        ratio = float(np.max(known[name].value) / np.max(truth[name].value))
        assert 0.5 < ratio < 2.0, (name, ratio)


def test_samples_that_were_left_out_move_the_fit_when_they_count(tmp_path):
    recording = recorded(tmp_path / "r", ("saturation", "imu2", {"limit": 1.2, "channels": ["gyro"]}))
    samples = check_samples(recording)
    assert not samples.masks["imu2.gyro"].all()
    fit = nominal_fit(recording, samples.masks)
    ((_, known),) = shifts_of([said("saturation", "imu2")], fit, samples, recording)
    assert known["hinge_angle"].value > 0.1  # clipped for whole strokes at a fraction of their rate
    ((_, other),) = moves_of([said("saturation", "imu1")], fit, samples, recording)
    assert other["hinge_angle"].value == 0.0  # nothing of that sensor was left out


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    """A hinge without any effect, and its fit."""
    recording = recorded(tmp_path_factory.mktemp("clean") / "r")
    return recording, fitted(recording)


def test_louder_noise_moves_by_how_it_is_weighed(clean):
    recording, fit = clean
    fit = replace(fit, noise=fit.noise | {"imu2.gyro": 5 * fit.noise["imu2.gyro"]})
    known = moves(fit, said("gyro_noise", "imu2"), recording)
    assert 0.0 < float(known["hinge_angle"].value) < 0.5  # both weights agree on a clean recording


def test_nothing_is_said_of_what_the_fit_does_not_hold(clean):
    recording, fit = clean
    samples = check_samples(recording)
    for finding in (said(UNKNOWN, "imu1"), said("joint_play", "joint"), said("accel_bias", "imu1")):
        assert fit_without(fit, finding, samples, recording) is None
        assert moves(fit, finding, recording) == {}
    assert is_material({}, TOLERANCE)


def test_nothing_is_said_of_a_torque_that_drives_a_free_swing(tmp_path):
    """With the sensors in the fit it moves nothing; a swing that is rolled out without it ends elsewhere."""
    friction = ("viscous_friction", "joint", {"c": 0.02})
    recording = recorded(tmp_path / "r", friction, rig="pendulum", swing=True)
    fit = fitted(recording, ("viscous_friction", "joint"))
    assert moves(fit, said("viscous_friction", "joint"), recording) == {}


def test_what_can_be_asked_of_each_rig(tmp_path):
    """A pendulum has no axis, a free body no joint; beside a measured orientation the heading counts."""
    names = {}
    for rig in ("hinge", "pendulum", "free"):
        recording = recorded(tmp_path / rig, rig=rig)
        fit = first_fit(model_of(recording), 2)  # what can be asked does not hang on how good it is
        here = estimates_of(fit, times(fit))
        same = moves_between(here, here, recording)
        assert all(np.all(move.value < 1e-9) for move in same.values())
        names[rig] = set(same)
    assert names["hinge"] == {"joint_axis", "joint_centre", "hinge_angle", "hinge_angle_constant", "orientation"}
    assert names["pendulum"] == {"joint_centre", "orientation"}
    assert names["free"] == {"mount_rotation", "lever", "orientation"}


def test_the_angle_of_a_turn():
    rng = np.random.default_rng(1)
    one = rotations.to_matrix(rotations.exp(rng.normal(size=(50, 3))))
    by = rng.normal(size=(50, 3))
    by *= (rng.uniform(1e-9, 3.1, 50) / np.linalg.norm(by, axis=1))[:, None]
    other = one @ rotations.to_matrix(rotations.exp(by))
    np.testing.assert_allclose(turned(one, other), np.linalg.norm(by, axis=1), atol=1e-9)


@pytest.mark.parametrize(("shift", "off"), [((0.0, 0.02, 0.0), 0.0), ((0.02, 0.0, 0.0), 20.0)])
def test_a_place_along_the_hinge_s_axis_is_no_other_centre(shift, off, tmp_path):
    """Both sensors 20 mm along the axis (y), of which no sample tells, or across it."""
    recording = recorded(tmp_path / "r")
    fit = fitted(recording)
    values = dict(fit.state.values)
    for name in ("imu1.translation", "imu2.translation"):
        values[name] = values[name] + shift
    other = replace(fit, state=replace(fit.state, values=values))
    time = times(fit)
    known = moves_between(estimates_of(fit, time), estimates_of(other, time), recording)
    assert known["joint_centre"].value == pytest.approx([off, off], abs=1e-9)  # rounding: the shift is exact
