"""`imubench diagnose` as a user calls it, and the parts that lead to it, on short recordings."""

import json
import sys
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from imubench.correction.found_rig import rig_of
from imubench.correction.replay import truth_of_motion
from imubench.correction.sensor_chain import read_by
from imubench.diagnosis import on_disk
from imubench.diagnosis.evidence import Played
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.result_file import as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.diagnosis.samples.quiet_moments import quiet_level
from imubench.diagnosis.verdict.reference_motion import motion_errors
from imubench.format1 import write_recording
from imubench.recording import Recording
from imubench.reference import Reference
from imubench.rotations import exp, from_axis_angle, multiply, rotate_back
from imubench.run import reference_of
from imubench.sim import rigs
from imubench.sim.imu_model import Declared, DeclaredMount, observe
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.signals import hand
from tests import command
from tests.command import here

SECONDS = 10.0
WHITE = ImuProfile("white", 50.0, ChannelProfile(noise_std=0.004), ChannelProfile(noise_std=0.02))


def moved_hinge(seed: int = 1) -> tuple[Recording, Reference]:
    """A hinge moved by hand, its mounts known, white noise alone."""
    rng = np.random.default_rng(seed)
    stds = {"heading": 0.8, "tilt": 0.4, "spin": 0.8, "angle": 0.7, "x": 0.1, "y": 0.1, "z": 0.05}
    rig = rigs.hinge()
    truth = play(rig, AngleMotion(**{n: hand(rng, SECONDS, s, 1.0) for n, s in stds.items()}), SECONDS, 500.0)
    mounts = {f"imu{i + 1}": DeclaredMount(m.position, m.quaternion, 1e-3, 5e-3) for i, m in enumerate(rig.mounts)}
    recording = observe(truth, WHITE, rng, "moved", Declared(mounts))
    return recording, reference_of(truth, recording)


def knocked(recording: Recording) -> Recording:
    """The same with the second accelerometer off by 0.5 m/s^2 along y from 4 to 6 s."""
    one, two = recording.imus
    off = 0.5 * ((two.time > 4) & (two.time < 6))
    return replace(recording, imus=(one, replace(two, accel=two.accel + off[:, None] * [0.0, 1.0, 0.0])))


imubench = partial(command.imubench, limit=900, OMP_NUM_THREADS="1", COLUMNS="200")


@pytest.fixture(scope="module")
def clean() -> tuple[Recording, Reference]:
    return moved_hinge()


@pytest.mark.slow
def test_the_command_writes_everything_and_prints_the_verdict(clean, tmp_path):
    recording, reference = clean
    write_recording(knocked(recording), tmp_path / "rec", reference)
    done = imubench("diagnose", "rec", "--out", "out", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    found = read_diagnosis(tmp_path / "out")
    assert found.verdict != "no mismatch"
    assert found.verdict in done.stdout
    assert found.where[0].at == "imu2"
    assert "acc_y" in found.where[0].channels
    assert found.fit.reference.before["hinge_angle"] < np.deg2rad(2)  # a knocked, short recording
    assert {"diagnosis.json", "report.html", "diagnosis.rrd"} <= {p.name for p in (tmp_path / "out").iterdir()}
    assert (tmp_path / "out" / "report.html").read_text().startswith("<!doctype html>")
    assert (tmp_path / "out" / "diagnosis.rrd").stat().st_size > 50_000
    again = imubench("diagnose", "rec", "--out", "out", folder=tmp_path)  # its own output may be replaced
    assert again.returncode == 0, again.stderr


@pytest.mark.long
def test_noise_alone_is_no_mismatch(clean):
    found, evidence = diagnose(clean[0])
    assert found.verdict == "no mismatch"
    # the power of 6000 numbers scatters by 2 %; the accelerometers' level comes out up to 13 % low, a quarter in power
    assert 0.8 < found.misfit[0] < 1.06
    assert json.dumps(as_dict(found), allow_nan=False)
    assert [t.name for t in evidence.traces] == ["imu1.gyro", "imu1.accel", "imu2.gyro", "imu2.accel"]
    truth = clean[1]
    assert (
        motion_errors(evidence.motion, truth, evidence.span)["hinge_angle"] < 0.01
    )  # the declared mounts' own 5e-3 rad about the hinge


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("diagnose", "nowhere"), "nowhere"),
        (("diagnose", "broken"), "broken"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_left(words, message, tmp_path):
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "recording.toml").write_text("format = 2")
    done = here(*words, "--out", "out", folder=tmp_path)
    assert done.code == 2
    assert message in done.err
    assert len(done.err.strip().splitlines()) == 1, done.err
    assert [p.name for p in tmp_path.iterdir()] == ["broken"]


def test_the_report_is_drawn_without_matplotlib(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)  # an import of it fails
    write_recording(short(), tmp_path / "rec")
    on_disk.diagnose_on_disk(tmp_path / "rec", tmp_path / "out")
    text = (tmp_path / "out" / "report.html").read_text()
    assert text.startswith("<!doctype html>")
    assert f"imubench run {tmp_path / 'out'}/model" in text  # as a reader would type it


def short() -> Recording:
    """Two seconds of the moved hinge: too little to look for anything, but fitted."""
    recording, _ = moved_hinge()
    imus = [replace(i, time=i.time[:100], gyro=i.gyro[:100], accel=i.accel[:100]) for i in recording.imus]
    return replace(recording, imus=tuple(imus))


def test_every_step_of_a_diagnosis_is_a_stage_that_is_counted(tmp_path):
    asked = []

    @contextmanager
    def step(what):
        asked.append(what)
        yield

    write_recording(short(), tmp_path / "rec")
    on_disk.diagnose_on_disk(tmp_path / "rec", tmp_path / "out", step)
    places = [next(i for i, name in enumerate(on_disk.STEP_BEGINNINGS) if what.startswith(name)) for what in asked]
    assert places == sorted(places)
    assert len(asked) >= 8


def test_help_says_what_it_does_and_writes(tmp_path):
    text = here("diagnose", "--help", folder=tmp_path).out
    for word in ("diagnosis.json", "report.html", "diagnosis.rrd", "format 1", "--out"):
        assert word in text


def test_a_recording_too_short_or_too_still_says_what_is_missing():
    found, _ = diagnose(short())
    assert found.verdict == "unobservable"
    assert "20 s" in found.unseen[0].motion


def test_one_imu_on_a_free_body_cannot_be_checked(clean):
    alone = replace(clean[0], rig="free", imus=clean[0].imus[:1])
    found, _ = diagnose(alone)
    assert found.verdict == "unobservable"
    assert "second IMU" in found.unseen[0].motion


def test_mujoco_reads_what_the_fitted_model_reads(clean):
    """Two implementations of the same rig: the fit's own kinematics, and MuJoCo playing the fitted motion."""
    recording = clean[0]
    fit = nominal_fit(recording)
    mounts = fit_summary.mounts(fit)
    truth = truth_of_motion(rig_of(recording, mounts), fit_summary.played(fit), 0.0, SECONDS, 50.0)
    rows = {r.name: r for r in fit.measured}
    for imu in recording.imus:
        _, gyro, accel = read_by(truth, 0.0, np.clip(rows[f"{imu.name}.gyro"].time, 0.0, None), imu.name, ())
        for part, got, sample in (("gyro", gyro, imu.gyro), ("accel", accel, imu.accel)):
            predicted = sample + rows[f"{imu.name}.{part}"].residual.value
            # cubic interpolation at 400 Hz and of the joint's force at 200 Hz, of a motion with noise up to 25 Hz
            np.testing.assert_allclose(got[5:-5], predicted[5:-5], atol=1e-3)


def test_the_channel_that_gains_most_is_shown():
    rng = np.random.default_rng(2)
    time, y = np.arange(100) / 50, rng.normal(size=(100, 3))
    wrong = y + np.array([0.1, 0.5, 0.0])
    groups = {"imu1.gyro": 0.1, "imu1.accel": 1.0}
    (one,) = fit_summary.compared(
        dict.fromkeys(groups, time),
        dict.fromkeys(groups, y),
        dict.fromkeys(groups, wrong),
        dict.fromkeys(groups, y),
        groups,
    )
    assert one.channel == "imu1.gyr_y"
    np.testing.assert_array_equal(one.before, wrong[:, 1])


def test_quiet_moments_give_the_noise_and_motion_does_not(clean):
    rng = np.random.default_rng(5)
    time = np.arange(3000) / 100
    moving = np.sin(2 * np.pi * 3 * time) * (time > 5)
    values = 0.02 * rng.normal(size=(3000, 3)) + moving[:, None]
    # the least of 10 quiet windows of 50 samples in 3 channels: scatter 6 %, and the quietest are a little low
    assert quiet_level(time, values) == pytest.approx(0.02, rel=0.15)


def test_a_rounded_sensor_that_rests_is_as_noisy_as_its_rounding():
    """It said 0, and a noise of 0 ended the diagnosis of a coarse gyroscope whose noise nobody declares."""
    time = np.arange(3000) / 100
    turning = 0.5 * np.sin(2 * np.pi * 0.3 * time[:, None] + np.arange(3)) * (time[:, None] > 5)
    assert quiet_level(time, 0.058 * np.round(turning / 0.058)) == pytest.approx(0.058 / np.sqrt(12), rel=1e-6)
    assert quiet_level(time, np.zeros((3000, 3))) > 0


def test_errors_against_a_reference_leave_one_heading_out():
    time = np.arange(500) / 50
    turn = exp(np.stack([0.3 * np.sin(time), 0.4 * np.sin(1.3 * time), 0.5 * time], axis=1))
    angle = np.sin(time)
    off = from_axis_angle([0.0, 0.0, 1.0], 0.7)
    tilted = multiply(multiply(off, turn), exp([0.02, 0.0, 0.0]))
    motion = Played(time, turn, np.zeros((500, 3)), angle + 0.01)
    reference = Reference(time[::3], hinge_angle=angle[::3], quaternion1=tilted[::3])
    found = motion_errors(motion, reference, (time[0], time[-1]))
    assert found["hinge_angle"] == pytest.approx(0.01, rel=1e-6)  # same stamps, nothing interpolated
    assert found["hinge_angle_but_constant"] == pytest.approx(0.0, abs=1e-9)
    assert found["orientation1"] == pytest.approx(0.02, rel=0.02)  # part of the tilt may pass for heading


def test_a_heading_that_drifts_is_no_tilt():
    time = np.arange(500) / 50
    turn = exp(np.stack([0.3 * np.sin(time), 0.4 * np.sin(1.3 * time), 0.5 * time], axis=1))
    drift = exp(np.stack([0 * time, 0 * time, 0.01 * (time - time.mean())], axis=1))
    tilted = multiply(multiply(drift, turn), exp([0.02, 0.0, 0.0]))
    found = motion_errors(Played(time, turn, np.zeros((500, 3)), None), Reference(time, quaternion1=tilted), (0, 10))
    vertical = rotate_back(turn, np.array([0.0, 0.0, 1.0]))
    seen = np.sqrt(np.mean(0.02**2 * (vertical[:, 1] ** 2 + vertical[:, 2] ** 2)))  # a turn about x moves y and z
    assert found["tilt1"] == pytest.approx(seen, rel=1e-3)
    assert found["orientation1"] > 0.03  # a hundredth rad a second, for 10 s


def test_where_nothing_was_measured_the_motion_is_not_held_against_a_reference():
    time = np.arange(500) / 50
    angle = np.where((time < 1.0) | (time > 9.0), 2.0, 0.0)  # splines run wild beyond the samples
    motion = Played(time, np.tile([1.0, 0.0, 0.0, 0.0], (500, 1)), np.zeros((500, 3)), angle + 0.02 * np.sin(time))
    found = motion_errors(motion, Reference(time, hinge_angle=np.zeros(500)), (1.0, 9.0))
    assert 0.01 < found["hinge_angle"] < 0.02


@pytest.mark.slow
def test_a_real_recording_end_to_end(recordings, tmp_path):
    made = imubench(
        "convert", "diodem", recordings / "diodem" / "trial1", "--option", "segments=3-4", "--option", "imu=nonrigid",
        "--out", "rec", folder=tmp_path,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    done = imubench("diagnose", "rec", "--out", "out", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    found = read_diagnosis(tmp_path / "out")
    assert found.verdict != "no mismatch"
    assert {w.at for w in found.where} == {"imu1", "imu2"}
