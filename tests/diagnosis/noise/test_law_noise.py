"""What the measurements' noise does to a spring's law, and to what is said of its numbers."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.criteria.plausible_fit import laws, natural
from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.noise.debias import NoiseOnLaws
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import fit_with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.clock_offsets import pose_offset
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

SEED = 910  # soft springs at imu2, damping 0.045


def test_information_that_is_noise_makes_steps_longer():
    whole, noise = np.diag([4.0, 9.0]), np.diag([2.0, 0.0])
    grown = NoiseOnLaws(np.zeros(2), noise, whole).grown()
    assert np.allclose(grown, np.diag([2.0, 1.0]))  # I (I - N)^-1
    all_noise = NoiseOnLaws(np.zeros(1), np.eye(1), np.eye(1)).grown(most=0.9)
    assert np.allclose(all_noise, 10.0)  # and no longer than that


def test_what_drives_a_law_is_what_it_reads_with_the_sensor_at_rest(tmp_path):
    """Springs carry the specific force: what an accelerometer on a still mount reads, in the law's 0.1 m/s^2."""
    make_case(tmp_path / "r", "pendulum", [], 3, seconds=10.0)
    recording = read(tmp_path / "r")[0]
    h = Hypothesis(EFFECTS["soft_mount"], "imu1")
    begun = extended(nominal_fit(recording), (h,))
    moved = begun.state.coefficients.copy()
    moved[:, begun.model.tracks.columns(h.key("displacement"))] += 0.01
    ((left, drive),) = laws(replace(begun, state=replace(begun.state, coefficients=moved)), [h])
    assert left == begun.noise[h.key("balance")]
    assert drive == laws(begun, [h])[0][1]  # wherever the sensor is now
    same = np.sqrt(np.mean(recording.imus[0].accel ** 2)) / 0.1
    assert drive == pytest.approx(same, rel=0.05)  # 2.4 %: the knots go on beyond the samples


@pytest.mark.long
@pytest.mark.parametrize(("name", "parameter"), [("viscous_friction", "c"), ("joint_spring", "k")])
def test_a_friction_that_drives_is_none_nor_a_spring_that_pushes_away(tmp_path, name, parameter):
    make_case(tmp_path / "r", "pendulum", [(name, "joint")], 3, seconds=10.0, swing=True)
    h = Hypothesis(EFFECTS[name], "joint")
    fit = extended(nominal_fit(read(tmp_path / "r")[0]), (h,))
    for value, fine in ((0.01, True), (-0.01, False)):
        told = replace(fit.state, values=fit.state.values | {h.key(parameter): np.array([value])})
        assert natural(replace(fit, state=told), h) is fine


def test_a_late_pose_is_seen_before_any_fit(tmp_path):
    truth = make_case(tmp_path / "r", "free", [("time_offset", "imu1")], 11, seconds=10.0)["effects"][0]["parameters"]
    recording = read(tmp_path / "r")[0]
    assert pose_offset(recording.imus[0], recording.poses[0]) == pytest.approx(truth["offset"], abs=1e-3)
    assert pose_offset(recording.imus[0], replace(recording.poses[0], quaternion=None)) == 0.0


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="1.23 apart, 1.08 wanted: rounds end where they gain next to nothing")
def test_a_damping_is_found_from_either_side_and_told_as_unsure_as_it_is(tmp_path):
    truth = make_case(tmp_path / "r", "hinge", [("soft_mount", "imu2")], SEED, seconds=12.0)["effects"][0]["parameters"]
    nominal = nominal_fit(read(tmp_path / "r")[0])
    found = []
    for start in (0.015, 0.2):
        h = Hypothesis(EFFECTS["soft_mount"].starting(frequency=truth["frequency"], damping_ratio=start), "imu2")
        begun = extended(nominal, (h,))
        key = h.key("damping_ratio")
        quiet = begun.noise | {"imu1.accel": 0.02, "imu2.accel": 0.02, h.key("balance"): 0.3}
        held = replace(begun.model, fixed={key: np.log([start])})
        state = solve(held, begun.state, quiet, begun.anchor, steps=6).state
        fit = fit_with_noise(begun.model, state, quiet, begun.anchor, rounds=40)  # a tight law makes short steps
        found.append((float(fit.state.values[key][0]), float(parameter_std(fit)[key][0])))
    (low, unsure), (high, doubt) = found
    true = np.log(truth["damping_ratio"])
    assert abs(low - high) < unsure  # two ways to one answer
    assert abs(low - true) < 2 * unsure
    assert abs(high - true) < 2 * doubt
    assert doubt > 0.2  # twelve seconds of a spring that noise shakes more than motion does
