"""What pairs the signs of two hinge axes is right, or `unknown`: in estimates, scores, files and lines."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.hinge_rigs import random_rig
from imubench.answers import beside_axes, estimate_as_dict, pairing_note, score_as_dict
from imubench.cli import app
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.estimators import ESTIMATORS
from imubench.estimators.pairing import told_by_data, told_by_mounts
from imubench.format1 import write_recording
from imubench.log.signals import aligned
from imubench.log.summary import verdict
from imubench.recording import Recording
from imubench.run import simulate
from imubench.score import line_deviation, score
from imubench.sim import rigs
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play

QUICK = ("olsson2020", "seel2012", "accel-svd", "qmt")
SCENARIOS = ("hinge-hand", "hinge-planar", "hinge-walking")
OTHER = np.array([[1.0], [-1.0]])


def undeclared(recording: Recording) -> Recording:
    """Return the recording of somebody who does not say how the sensors sit."""
    plain = {"mount_rotation_std": None, "mount_quaternion": np.array([1.0, 0, 0, 0])}
    return replace(recording, imus=tuple(replace(imu, **plain) for imu in recording.imus))


@pytest.fixture(
    scope="module", params=[(s, seed) for s in SCENARIOS for seed in range(2)], ids=lambda p: f"{p[0]}-{p[1]}"
)
def simulated(request):
    recording, truth = simulate(*request.param)
    axes = np.stack([s.joint_axis.mean(axis=0) for s in truth.sensors])
    return request.param[0], recording, axes


@pytest.mark.parametrize("declared", [True, False])
@pytest.mark.parametrize("name", QUICK)
def test_a_pairing_that_is_claimed_is_right(name, declared, simulated):
    """A still, horizontal axis shows accelerometers nothing: without mounts half of such claims were wrong."""
    if name == "qmt":
        pytest.importorskip("qmt", reason="needs the extra: pip install 'imubench[peers]'")
    scenario, recording, axes = simulated
    answer = ESTIMATORS[name].estimate(recording if declared else undeclared(recording))
    assert answer.pairing in ("from data", "from declared mounts", "unknown")
    if answer.status == "not identifiable":
        assert answer.pairing == "unknown"
        return
    right = np.prod(np.sum(answer.value * axes, axis=1)) > 0
    assert right or answer.pairing == "unknown"
    if declared:
        assert right
    seen = name != "seel2012" and scenario != "hinge-planar"  # gyroscopes see no sign, nor do accelerometers there
    if seen and name == "olsson2020":
        assert answer.pairing == "from data"
    if not seen:
        assert answer.pairing == ("from declared mounts" if declared else "unknown")


def test_a_stream_says_it_too():
    recording, truth = simulate("hinge-hand", 1)
    axes = np.stack([s.joint_axis.mean(axis=0) for s in truth.sensors])
    answer = ESTIMATORS["olsson2020-plug-and-play"].estimate(undeclared(recording))
    assert (answer.status, answer.pairing) == ("converged", "from data")
    assert np.prod(np.sum(answer.value * axes, axis=1)) > 0


def test_what_both_accelerometers_read_along_the_hinge_tells():
    rng = np.random.default_rng(0)
    rig = random_rig(rng, lever=0.05).noisy(rng, 0.002, 0.02)
    assert told_by_data(*rig.accel, rig.axes)
    assert not told_by_data(*rig.accel, rig.axes * OTHER)
    assert not told_by_data(*rig.accel[:, :0], rig.axes)


@pytest.mark.parametrize("signs", [1.0, -1.0])
def test_biases_alone_do_not_tell(signs):
    """Two biases of 0.2 m/s^2 agree, or do not, to 99 %: whatever the noise, that is no specific force."""
    rng = np.random.default_rng(1)
    along = np.stack([np.full(2000, 0.2), np.full(2000, 0.2 * signs)]) + 0.02 * rng.normal(size=(2, 2000))
    gravity = np.tile([9.81, 0.0, 0.0], (2000, 1))
    accel = [gravity + x[:, None] * [0.0, 1.0, 0.0] for x in along]
    assert not told_by_data(*accel, np.tile([0.0, 1.0, 0.0], (2, 1)))


@pytest.mark.parametrize(("std", "degrees", "told"), [
    (0.02, 0.0, True), (0.02, 80.0, True), (0.02, 88.0, False), (0.4, 10.0, True), (0.4, 30.0, False),
    (1.0, 0.0, False), (None, 0.0, False),
])  # fmt: skip
def test_a_declared_mount_tells_as_far_as_it_is_known(std, degrees, told):
    """Three std and the angle between the estimated and the declared axis together have to stay below 90 deg."""
    recording = random_rig(np.random.default_rng(0)).recording()
    turned = np.deg2rad(degrees)
    imus = tuple(
        replace(imu, mount_rotation_std=std, mount_quaternion=np.array([1.0, 0, 0, 0])) for imu in recording.imus
    )
    axes = np.tile([np.sin(turned), np.cos(turned), 0.0], (2, 1))
    for signs in (np.ones((2, 1)), OTHER):
        assert told_by_mounts(replace(recording, imus=imus), axes * signs) is told


def axis_estimate(value: np.ndarray, pairing: str | None) -> Estimate:
    return Estimate("joint_axis", "test", value, None, "a test needs none", pairing=pairing)


def test_the_score_of_an_unknown_pairing_is_named_so():
    truth = play(rigs.random_hinge(np.random.default_rng(0)), AngleMotion(), 0.1)
    axes = np.stack([s.joint_axis.mean(axis=0) for s in truth.sensors])
    for value in (axes, axes * OTHER, -axes):
        judged = score(axis_estimate(value, "unknown"), truth)
        assert judged.figures.keys() == {
            "best_pairing_deviation_imu1", "best_pairing_deviation_imu2", "best_pairing_rmsae", "best_pairing_maxae",
        }  # fmt: skip
        assert max(judged.figures.values()) < 1e-7  # rounding of an arc tangent near 0 and pi
        assert score_as_dict(judged)["pairing"] == "unknown"
        assert judged.deviation("imu2") == judged.figures["best_pairing_deviation_imu2"]
    for pairing in ("from data", "from declared mounts", None):
        judged = score(axis_estimate(axes * OTHER, pairing), truth)
        assert judged.figures["maxae"] == pytest.approx(np.pi)  # a claim, and a wrong one
        assert score_as_dict(judged)["pairing"] == pairing


def test_lines_have_no_signs():
    tilted = np.array([0.0, np.cos(0.2), np.sin(0.2)])
    assert line_deviation([tilted, -tilted], np.tile([0.0, 1.0, 0.0], (2, 1))) == pytest.approx([0.2, 0.2])


def test_only_known_words_and_only_axes_have_a_pairing():
    y = np.tile([0.0, 1.0, 0.0], (2, 1))
    with pytest.raises(InputError, match="unknown pairing of test 'guessed'; known: from data, from declared mounts"):
        axis_estimate(y, "guessed")
    with pytest.raises(InputError, match=r"test\.pairing: expected none for a joint_vector, got 'from data'"):
        Estimate("joint_vector", "test", y, None, "none", pairing="from data")


def test_files_and_lines_say_it():
    recording = random_rig(np.random.default_rng(3)).recording()
    axes = random_rig(np.random.default_rng(3)).axes
    answer = ESTIMATORS["seel2012"].estimate(recording)
    assert estimate_as_dict(answer)["pairing"] == "unknown"
    assert "pairing_known" not in answer.details
    assert pairing_note(answer, recording) == "sign pairing unknown: no declared mounts"
    assert beside_axes(answer, recording, axes).figures.keys() == {
        "best_pairing_deviation_imu1", "best_pairing_deviation_imu2",
    }  # fmt: skip
    assert "Their sign pairing is unknown" in verdict(recording, answer, None, {})
    assert "Their sign pairing is unknown" in verdict(recording, answer, None, {"imu1": 0.1, "imu2": 0.2})
    sure = replace(recording, imus=tuple(replace(imu, mount_rotation_std=0.02) for imu in recording.imus))
    known = ESTIMATORS["seel2012"].estimate(sure)
    assert pairing_note(known, sure) == "sign pairing from declared mounts"
    assert pairing_note(replace(known, pairing=None), sure).startswith("sign pairing not said by the estimator")
    assert pairing_note(replace(known, pairing="unknown"), sure).endswith("the declared mounts do not tell it")
    theirs = replace(known, pairing="unknown", estimator="mine.py:estimate")  # which never asked the mounts
    assert pairing_note(theirs, sure).startswith("sign pairing unknown, the estimator says")
    vector = Estimate("joint_vector", "test", axes, None, "none")
    assert pairing_note(vector, recording) == ""
    assert "pairing" not in estimate_as_dict(vector)


def test_drawn_axes_of_an_unknown_pairing_are_turned_one_by_one():
    axes = random_rig(np.random.default_rng(3)).axes
    np.testing.assert_array_equal(aligned(axes * OTHER, axes, together=False), axes)
    np.testing.assert_array_equal(aligned(axes * OTHER, axes), axes * OTHER)
    np.testing.assert_array_equal(aligned(-axes, axes), axes)


def test_the_command_prints_and_writes_it(tmp_path):
    recording = random_rig(np.random.default_rng(3)).recording()
    write_recording(recording, tmp_path / "r")
    done = CliRunner().invoke(app, ["estimate", "seel2012", str(tmp_path / "r"), "--out", str(tmp_path / "out")])
    assert "sign pairing unknown: no declared mounts" in done.stdout
    assert json.loads((tmp_path / "out" / "estimate.json").read_text())["pairing"] == "unknown"
    done = CliRunner().invoke(app, ["run", "hinge-hand", "--estimator", "seel2012", "--out", str(tmp_path / "run")])
    assert "sign pairing from declared mounts" in done.stdout
    content = json.loads((tmp_path / "run" / "score.json").read_text())
    assert content["pairing"] == content["estimate"]["pairing"] == "from declared mounts"
    assert "maxae" in content["figures"]
