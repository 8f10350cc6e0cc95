"""A run in Rerun, read back value by value."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from rerun.chunk import RrdReader

from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.log import log_run
from imubench.log.summary import deviations, verdict
from imubench.models.tree import UNREAD
from imubench.recording import Encoder, Imu, Pose, Recording
from imubench.reference import Reference
from imubench.rotations import angle_between, exp
from imubench.score import score
from tests.logged import MOUNTS, Log, axis_estimate, hinge_truth, nanoseconds, observed, pendulum_truth


@pytest.fixture(scope="module")
def truth():
    return hinge_truth()


@pytest.fixture(scope="module")
def run(truth, tmp_path_factory):
    """A scored run of the hinge, read back."""
    path = tmp_path_factory.mktemp("run") / "run.rrd"
    recording, estimate = observed(truth), axis_estimate(truth)
    log_run(path, recording, truth, estimate, score(estimate, truth))
    return recording, Log(path)


def test_signals_come_back_to_the_bit_at_their_stamps(run):
    recording, log = run
    for imu in recording.imus:
        for what in ("gyro", "accel"):
            stamps, values = log.read(f"/{imu.name}/{what}", "Scalars:scalars")
            np.testing.assert_array_equal(stamps, nanoseconds(imu.time))
            np.testing.assert_array_equal(values, getattr(imu, what))
    assert log.static("/imu2/gyro", "SeriesLines:names").tolist() == [
        "gyro x (rad/s)",
        "gyro y (rad/s)",
        "gyro z (rad/s)",
    ]
    assert log.static("/imu1/accel", "SeriesLines:names")[2] == "accel z (m/s²)"


def test_true_signals_stand_beside_the_measured_ones(run, truth):
    _, log = run
    # the stamps are every second sample of the truth, so interpolation only rounds
    _, gyro = log.read("/truth/imu1/gyro", "Scalars:scalars")
    np.testing.assert_allclose(gyro, truth.sensors[0].gyro[::2], atol=1e-12)
    _, force = log.read("/truth/imu2/specific_force", "Scalars:scalars")
    np.testing.assert_allclose(force, truth.sensors[1].specific_force[::2], atol=1e-12)


def test_segments_move_as_in_the_truth(run, truth):
    _, log = run
    rows = np.append(np.arange(0, 800, 3), 799)  # 200 Hz brought down to 67 Hz, the end kept
    for segment in truth.segments:
        stamps, xyzw = log.read(f"/world/{segment.name}", "Transform3D:quaternion")
        np.testing.assert_array_equal(stamps, nanoseconds(truth.time[rows]))
        # Rerun keeps transforms in single precision, 6e-8 of 1
        np.testing.assert_allclose(xyzw[:, 0], segment.quaternion[rows][:, [1, 2, 3, 0]], atol=1e-7)
        _, place = log.read(f"/world/{segment.name}", "Transform3D:translation")
        np.testing.assert_allclose(place[:, 0], segment.position[rows], atol=1e-7)


def test_the_joint_angle_is_logged_in_full(run, truth):
    stamps, angle = run[1].read("/joint/angle", "Scalars:scalars")
    np.testing.assert_array_equal(stamps, nanoseconds(truth.time))
    np.testing.assert_array_equal(angle[:, 0], truth.joint_angle)


def test_imus_sit_where_the_truth_has_them(run):
    _, log = run
    for name, (place, rotation) in MOUNTS.items():
        path = f"/world/segment{name[-1]}/{name}"
        # single precision, 6e-8 of 1
        np.testing.assert_allclose(log.static(path, "Transform3D:translation")[0], place, atol=1e-7)
        quaternion = log.static(path, "Transform3D:quaternion")[0]
        same = abs(quaternion @ exp(rotation)[[1, 2, 3, 0]])
        assert same == pytest.approx(1.0, abs=1e-6)  # single precision, either sign
        np.testing.assert_allclose(log.static(f"{path}/case", "half_sizes")[0], [0.029, 0.017, 0.0075], atol=1e-9)


def test_axes_are_drawn_at_the_joint_in_each_sensor_frame(run, truth):
    _, log = run
    for sensor, off in zip(truth.sensors, (0.02, 0.15), strict=True):
        path = f"/world/segment{sensor.name[-1]}/{sensor.name}"
        true = log.static(f"{path}/axis_true", "Arrows3D:vectors")[0]
        estimated = log.static(f"{path}/axis_estimated", "Arrows3D:vectors")[0]
        # single precision of arrows of 0.1 to 0.3 m
        np.testing.assert_allclose(true / np.linalg.norm(true), sensor.joint_axis[0], atol=1e-6)
        # the estimate came with both signs turned: it is drawn towards the truth
        assert angle_between(estimated, true) == pytest.approx(off, abs=1e-6)
        for kind in ("true", "estimated"):
            origin = log.static(f"{path}/axis_{kind}", "Arrows3D:origins")[0]
            np.testing.assert_allclose(origin, sensor.joint_vector[0], atol=1e-7)
    colours = [log.static(f"/world/segment1/imu1/axis_{k}", "Arrows3D:colors")[0] for k in ("true", "estimated")]
    assert colours == [0x3CC85AFF, 0xFF8C19FF]  # green, orange


def test_the_constraint_is_that_of_the_axes_on_the_measured_rates(run, truth):
    recording, log = run
    w1, w2 = (imu.gyro for imu in recording.imus)
    j1, j2 = axis_estimate(truth).value
    _, left = log.read("/joint/constraint/estimated_axis", "Scalars:scalars")
    expected = np.linalg.norm(np.cross(w1, j1), axis=1) - np.linalg.norm(np.cross(w2, j2), axis=1)
    np.testing.assert_allclose(left[:, 0], expected, atol=1e-12)  # rounding
    _, floor = log.read("/joint/constraint/true_axis", "Scalars:scalars")
    # noise of 0.01 rad/s on both projections: RMS sqrt(2) of it, and three times that is never reached
    assert np.sqrt(np.mean(floor**2)) < 0.03 < np.sqrt(np.mean(left**2))


def test_the_error_is_in_degrees(run):
    for name, off in (("imu1", 0.02), ("imu2", 0.15)):
        _, error = run[1].read(f"/error/angle/{name}", "Scalars:scalars")
        np.testing.assert_allclose(error, np.rad2deg(off), atol=1e-9)  # rounding


def test_sections_are_states(run):
    stamps, states = run[1].read("/sections/motion", "StateChange:state")
    np.testing.assert_array_equal(stamps, nanoseconds([0.0, 2.0, 2.8, 3.0]))
    assert states[:, 0].tolist() == ["slow", "", "knock", ""]


def test_properties_summary_and_layout_travel_with_the_file(run):
    _, log = run
    table = log.chunks.reader(index=None, contents="/__properties/**").to_pandas().iloc[0]
    facts = {key: table[f"property:run:{key}"][0] for key in ("rig", "name", "estimator", "gravity")}
    assert facts == {"rig": "hinge", "name": "swing-by-hand", "estimator": "by-hand", "gravity": 9.81}
    text = log.static("/summary", "TextDocument:text")[0]
    assert text.startswith("### **by-hand** finds the hinge axis **1.15°** off in imu1 and **8.59°** off in imu2.\n")
    assert "| by-hand | imu2 | 8.594° | 0.57° | converged |" in text
    assert len(RrdReader(log.path).blueprints()) == 1


def test_a_wrong_pairing_and_a_failure_are_said(truth):
    recording, wrong = observed(truth), axis_estimate(truth, (0.02, np.pi - 0.05))
    found = deviations(["imu1", "imu2"], score(wrong, truth), None)
    assert "177.14°** off in imu2. The signs of the two axes are paired wrongly." in verdict(
        recording, wrong, None, found
    )
    still = replace(wrong, status="not identifiable")
    assert "does not identify the hinge axis" in verdict(recording, still, None, {})
    assert "did not converge" in verdict(recording, replace(wrong, status="not converged"), None, found)


def test_a_real_recording_without_truth_is_judged_by_its_constraint(truth, tmp_path):
    log_run(tmp_path / "run.rrd", observed(truth), estimate=axis_estimate(truth), name="bench 3")
    log = Log(tmp_path / "run.rrd")
    assert "no truth is known, but the hinge constraint is left at" in log.static("/summary", "TextDocument:text")[0]
    assert not {p for p in log.paths() if "true" in p or "truth" in p or "error" in p}
    value = log.static("/world/segment2/imu2/axis_estimated", "Arrows3D:vectors")[0]
    assert angle_between(value, axis_estimate(truth).value[1]) < 1e-6  # single precision; nothing to turn its sign by
    place = log.static("/world/segment1/imu1", "Transform3D:translation")[0]
    np.testing.assert_allclose(place, MOUNTS["imu1"][0], atol=1e-7)  # single precision


def test_true_axes_judge_a_real_recording(truth, tmp_path):
    axes = [s.joint_axis[0] for s in truth.sensors]
    log_run(tmp_path / "run.rrd", observed(truth), estimate=axis_estimate(truth), true_axes=axes)
    log = Log(tmp_path / "run.rrd")
    assert "**8.59°** off in imu2 against the reference axes." in log.static("/summary", "TextDocument:text")[0]
    vector = log.static("/world/segment2/imu2/axis_reference", "Arrows3D:vectors")[0]
    assert angle_between(vector, axes[1]) < 1e-6  # single precision


def test_without_estimate(truth, tmp_path):
    log_run(tmp_path / "run.rrd", observed(truth), truth)
    text = Log(tmp_path / "run.rrd").static("/summary", "TextDocument:text")[0]
    assert text.startswith("### Only signals")


def test_an_encoder_alone_moves_the_hinge(tmp_path):
    time = np.arange(300) / 50
    encoder = Encoder("hinge", time, np.sin(time), zero=0.25)
    log_run(tmp_path / "run.rrd", Recording("arm", "hinge", encoders=(encoder,)))
    log = Log(tmp_path / "run.rrd")
    _, angle = log.read("/encoder/hinge/angle", "Scalars:scalars")
    np.testing.assert_array_equal(angle[:, 0], np.sin(time) + 0.25)
    _, xyzw = log.read("/world/segment2", "Transform3D:quaternion")
    half = (np.sin(time) + 0.25) / 2
    np.testing.assert_allclose(xyzw[:, 0, 1], np.sin(half), atol=1e-7)  # single precision
    np.testing.assert_allclose(xyzw[:, 0, 3], np.cos(half), atol=1e-7)


def test_measured_poses_leave_out_what_was_not_seen(truth, tmp_path):
    position = truth.segments[0].position[::10].copy() + np.arange(80)[:, None] * 0.01
    position[5:9] = np.nan
    pose = Pose("segment1", truth.time[::10], position, truth.segments[0].quaternion[::10])
    log_run(tmp_path / "run.rrd", replace(observed(truth), poses=(pose,)))
    stamps, place = Log(tmp_path / "run.rrd").read("/world/segment1", "Transform3D:translation")
    seen = np.isfinite(position[:, 0])
    np.testing.assert_array_equal(stamps, nanoseconds(truth.time[::10][seen]))
    np.testing.assert_allclose(place[:, 0], position[seen], atol=1e-6)  # single precision of 1 m


def test_a_reference_moves_both_segments(truth, tmp_path):
    reference = Reference(
        truth.time[::5], truth.joint_angle[::5], truth.segments[0].quaternion[::5], truth.segments[1].quaternion[::5]
    )
    log_run(tmp_path / "run.rrd", observed(truth), reference=reference)
    log = Log(tmp_path / "run.rrd")
    _, xyzw = log.read("/world/segment2", "Transform3D:quaternion")
    np.testing.assert_allclose(xyzw[:, 0, [3, 0, 1, 2]], reference.quaternion2, atol=1e-7)  # single precision
    np.testing.assert_array_equal(log.read("/reference/hinge_angle", "Scalars:scalars")[1][:, 0], reference.hinge_angle)


def test_a_shaking_mount_and_an_estimate_per_sample(tmp_path):
    truth = pendulum_truth()
    sensor = truth.sensors[0]
    imu = Imu("imu1", truth.time[::10], sensor.gyro[::10], sensor.specific_force[::10], rate=100.0)
    value = sensor.joint_vector[::10, None] + [0.003, 0.0, 0.0]
    estimate = Estimate("joint_vector", "filter", value, None, "a filter without one", time=truth.time[::10])
    log_run(tmp_path / "run.rrd", Recording("p", "pendulum", (imu,)), truth, estimate, score(estimate, truth))
    log = Log(tmp_path / "run.rrd")
    stamps, error = log.read("/error/length/imu1", "Scalars:scalars")
    np.testing.assert_array_equal(stamps, nanoseconds(estimate.time))
    np.testing.assert_allclose(error, 0.003, atol=1e-12)  # rounding
    rows = np.append(np.arange(0, 4000, 17), 3999)  # 1 kHz brought down to 59 Hz, the end kept
    stamps, place = log.read("/world/segment1/imu1", "Transform3D:translation")
    np.testing.assert_array_equal(stamps, nanoseconds(truth.time[rows]))
    np.testing.assert_allclose(place[:, 0], -sensor.joint_vector[rows], atol=1e-7)  # single precision; no rotation
    _, r = log.read("/world/segment1/imu1/vector_true", "Arrows3D:vectors")
    np.testing.assert_allclose(r[:, 0], sensor.joint_vector[rows], atol=1e-7)
    _, r = log.read("/world/segment1/imu1/vector_estimated", "Arrows3D:vectors")
    drawn = np.append(np.arange(0, 400, 2), 399)  # 100 Hz brought down to 50 Hz
    np.testing.assert_allclose(r[:, 0], value[drawn, 0], atol=1e-7)
    assert "and 3.0 mm off in imu1" in log.static("/summary", "TextDocument:text")[0].replace("**", "")


def test_a_rig_that_travels_is_followed(truth, tmp_path):
    away = np.linspace(0, 5.0, truth.time.size)[:, None]
    moved = tuple(replace(s, position=s.position + away) for s in truth.segments)
    sensors = tuple(replace(s, position=s.position + away) for s in truth.sensors)
    log_run(tmp_path / "run.rrd", observed(truth), replace(truth, segments=moved, sensors=sensors))
    log = Log(tmp_path / "run.rrd")
    _, frame = log.read("/world/follow", "Transform3D:translation")
    _, segment = log.read("/world/segment1", "Transform3D:translation")
    np.testing.assert_array_equal(frame, segment)


def test_an_error_midway_leaves_nothing_and_keeps_the_old_file(truth, tmp_path, monkeypatch):
    path = tmp_path / "run.rrd"
    path.write_bytes(b"the run before")

    def broken(*_):
        raise RuntimeError("midway")

    monkeypatch.setattr("imubench.log.run.summary", broken)
    with pytest.raises(RuntimeError, match="midway"):
        log_run(path, observed(truth), truth)
    assert path.read_bytes() == b"the run before"
    assert [p.name for p in tmp_path.iterdir()] == ["run.rrd"]


def test_what_rerun_would_only_warn_about_is_an_error(truth, tmp_path, monkeypatch):
    monkeypatch.setattr("imubench.recording.rig_tree", lambda rig: UNREAD)  # no file says how large a case is
    monkeypatch.setattr("imubench.log.scene.FLAT_CASE", (0.1, 0.1))  # a box with two sides
    with pytest.raises(ValueError, match="multiple of 3"):
        log_run(tmp_path / "run.rrd", observed(truth), truth)
    assert list(tmp_path.iterdir()) == []


FULL_DISK = """
import resource, signal, sys
from pathlib import Path
import numpy as np
from imubench.recording import Imu, Recording
from imubench.errors import InputError
from imubench.log import log_run
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))
n = 60_000
imu = Imu("imu1", np.arange(n) / 100, np.random.default_rng(0).normal(size=(n, 3)), np.zeros((n, 3)), 100.0)
try:
    log_run(Path(sys.argv[1]), Recording("big", "free", (imu,)))
except InputError as error:
    print(error)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit on file sizes")
def test_a_full_disk_is_an_error_and_leaves_nothing(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, str(tmp_path / "run.rrd")],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert "run.rrd: expected a place that can be written, got: File too large" in done.stdout, done.stderr
    assert list(tmp_path.iterdir()) == []


def test_true_axes_of_a_wrong_shape(truth, tmp_path):
    with pytest.raises(InputError, match=r"true_axes: expected shape \(2, 3\), got \(3,\)"):
        log_run(tmp_path / "run.rrd", observed(truth), true_axes=[0.0, 1.0, 0.0])
    assert list(tmp_path.iterdir()) == []


def stamped(first: float, rate: float, count: int, imus: int = 2) -> Recording:
    time = first + np.arange(count) / rate
    gyro = np.random.default_rng(0).normal(size=(imus, count, 3))
    force = np.tile([0.0, 0.0, 9.81], (count, 1))
    sensors = tuple(Imu(f"imu{i + 1}", time, gyro[i], force, rate) for i in range(imus))
    return Recording("stamped", "hinge" if imus == 2 else "pendulum", sensors)


ODD = {
    "one sample": stamped(5.0, 100.0, 1, imus=1),
    "two samples": stamped(0.0, 100.0, 2),
    "half a hertz": stamped(0.0, 0.5, 30),
    "since 1970": stamped(1.7e9, 100.0, 300),
    "before zero": stamped(-1e9, 100.0, 300),
    "milliseconds since 1970": stamped(1.7e12, 0.1, 300),  # Rerun's clock ends after 292 years
    "a window without end": replace(stamped(0.0, 100.0, 20), free_swings=((0.0, 1e11),)),
}


@pytest.mark.parametrize("name", ODD)
def test_any_recording_can_be_logged(name, tmp_path):
    recording = ODD[name]
    log_run(tmp_path / "run.rrd", recording)
    if recording.imus[0].time[-1] < 9e9:  # else all samples stand at the end of Rerun's clock
        stamps, gyro = Log(tmp_path / "run.rrd").read("/imu1/gyro", "Scalars:scalars")
        np.testing.assert_array_equal(stamps, nanoseconds(recording.imus[0].time))
        np.testing.assert_array_equal(gyro, recording.imus[0].gyro)
    if len(recording.imus) == 2:
        axes = np.tile([0.0, 1.0, 0.0], (2, 1))
        log_run(tmp_path / "e.rrd", recording, estimate=Estimate("joint_axis", "test", axes, None, "none"))
    else:
        r = Estimate("joint_vector", "test", np.zeros((1, 1, 3)), None, "none", time=recording.imus[0].time)
        log_run(tmp_path / "e.rrd", recording, estimate=r)
