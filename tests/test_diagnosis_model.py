"""The simulation that a diagnosis leaves behind: written, read back, played by MuJoCo."""

import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench import rotations
from imubench.correction.export import SENSORS_FILE, write_model
from imubench.correction.found_rig import rig_of
from imubench.correction.read_model import read_model
from imubench.correction.replay import truth_of_motion
from imubench.correction.rig_file import read_rig
from imubench.correction.sensor_chain import read_by
from imubench.diagnosis.evidence import Evidence, FittedEffect, Level, Played, Pose, Trace
from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Interval, Parameter
from imubench.diagnosis.simulation.model_folder import replay
from imubench.errors import InputError
from imubench.inputs.toml import load_toml
from imubench.recording import Body, Encoder, Imu, Recording
from imubench.run import run_scenario
from imubench.sim import rigs
from imubench.sim.compile import compile_model
from imubench.sim.imu_sampling import low_pass
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.rigs import Mount
from imubench.sim.signals import hand
from tests.concealed import finding

SECONDS, RATE, KNOTS = 6.0, 100.0, 100.0
SOFT = Finding(
    "soft_mount",
    "imu2",
    0.9,
    {"frequency": Parameter([11.0, 12.0, 13.0], np.full(3, 0.1), "Hz"), "damping_ratio": Parameter(0.1, 0.01, "1")},
    Interval(100.0, (90.0, 110.0)),
)
ROCKING = Finding(
    "rocking_mount",
    "imu1",
    0.9,
    {
        "frequency": Parameter([9.0], [0.1], "Hz"),
        "damping_ratio": Parameter([0.15], [0.01], "1"),
        "com": Parameter([0.0, 0.001, 0.004], np.full(3, 1e-3), "m"),
        "lever": Parameter([0.0, 0.01, 0.02], np.full(3, 1e-3), "m"),
    },
    Interval(100.0, (90.0, 110.0)),
)
BIAS = Finding(
    "gyro_bias",
    "imu2",
    0.9,
    {"bias": Parameter([0.1, -0.2, 0.3], np.full(3, 0.01), "rad/s")},
    Interval(9.0, (8.0, 9.0)),
)
LATE = Finding("time_offset", "imu2", 0.9, {"offset": Parameter(0.02, 1e-4, "s")}, Interval(9.0, (8.0, 9.0)))
MOUNTS = {
    "imu1": Pose(np.array([-0.1, 0.01, 0.03]), rotations.exp(np.array([0.3, -0.2, 0.5]))),
    "imu2": Pose(np.array([0.12, 0.0, 0.02]), rotations.exp(np.array([-0.6, 0.4, 0.1]))),
}
STAMPS = np.arange(round(SECONDS * RATE)) / RATE


def movement():
    rng = np.random.default_rng(4)
    stds = {"heading": 0.8, "tilt": 0.4, "spin": 0.8, "angle": 0.7, "x": 0.1, "y": 0.1, "z": 0.05}
    return AngleMotion(**{name: hand(rng, SECONDS + 1, std, 1.5) for name, std in stds.items()})


def moved(later=0.0, **changes):
    """The motion as a fit would tell it: orientation, force at the joint and angle at knots."""
    time = np.arange(-0.15, SECONDS + 0.15, 1 / KNOTS)
    path = movement()(time + 0.3)
    q = path.quaternion
    q = (
        q
        * np.where(np.cumprod(np.concatenate([[1.0], np.sign(np.sum(q[1:] * q[:-1], axis=1))])) < 0, -1.0, 1.0)[:, None]
    )
    force = rotations.rotate_back(q, path.acceleration + np.array([0, 0, 9.81]))
    parts = {"position": np.zeros((time.size, 3)), "hinge_angle": path.angle, "force": force} | changes
    return Played(time + later, q, **parts)


def truth_of(rig):
    motion = movement()
    return play(rig, lambda time: motion(time + 0.3), SECONDS, 400.0)


def evidence(later=0.0):
    still = np.zeros((STAMPS.size, 3))
    imus = tuple(Imu(name, STAMPS + later, still, still, RATE) for name in MOUNTS)
    trace = Trace("imu1", "gyro", ("gyr_x", "gyr_y", "gyr_z"), "rad/s", STAMPS + later, still, 1.0)
    levels = tuple(Level(f"{n}.{p}", "1", None, 1e-12, 1e-12) for n in MOUNTS for p in ("gyro", "accel"))
    return Evidence(Recording("rec", "hinge", imus), (trace,), moved(later), MOUNTS, levels)


def diagnosis(*findings):
    verdict = "explained" if findings else "no mismatch"
    return Diagnosis("rec", "hinge", verdict, (4.0, 1.0), (), findings, (), FitQuality((4.0, 1.0)), "", 1.0)


def same_readings(recording, truth, shift=0.0):
    """Rates and forces of a replay beside those of the true motion on the same rig, past the springs' start."""
    at = truth.time
    for imu in recording.imus:
        sensor = truth.sensor(imu.name)
        late = imu.time - recording.imus[0].time[0] > 1.5  # springs of 9 Hz, damped by 0.1, ring for half a second
        for got, true in ((imu.gyro, sensor.gyro), (imu.accel, sensor.specific_force)):
            want = np.stack([np.interp(STAMPS - shift, at, x) for x in true.T], axis=1)
            yield imu.name, got[late], want[late]


@pytest.mark.parametrize("findings", [(), (SOFT,), (SOFT, ROCKING)], ids=["rigid", "soft", "both"])
def test_a_replay_reads_what_the_true_motion_makes_the_rig_read(findings, tmp_path):
    shown = evidence(later=1000.0)
    name = write_model(diagnosis(*findings), shown, tmp_path)
    assert name == "hinge.xml"
    recording, _ = replay(tmp_path, np.random.default_rng(0))
    assert [imu.name for imu in recording.imus] == ["imu1", "imu2"]
    assert_allclose(recording.imus[0].time, 1000.0 + STAMPS)
    rig = rig_of(shown.recording, MOUNTS, findings)
    assert rig.sprung == bool(findings)
    for _, got, want in same_readings(recording, truth_of(rig)):
        # 6 digits in the MJCF file and the truth read linearly at 400 Hz: 1e-5 and below 1e-3 of 10 m/s^2
        assert_allclose(got, want, atol=1e-2)


def test_springs_are_real_joints_of_the_file_and_come_back(tmp_path):
    shown = evidence()
    write_model(diagnosis(SOFT, ROCKING), shown, tmp_path)
    text = (tmp_path / "hinge.xml").read_text()
    assert len(re.findall(r'name="imu2_slide_[xyz]" type="slide" stiffness=', text)) == 3
    rig, read = rig_of(shown.recording, MOUNTS, (SOFT, ROCKING)), read_rig(tmp_path / "hinge.xml", "hinge")
    for want, got in zip(rig.mounts, read.mounts, strict=True):
        for key in ("position", "quaternion", "lever", "com"):
            assert_allclose(getattr(got, key), getattr(want, key), atol=1e-6)  # the file has 6 digits
        assert got.gyration == pytest.approx(want.gyration, rel=1e-5)
        for key in ("translation", "rotation"):
            springs = getattr(want, key)
            assert (springs is None) == (getattr(got, key) is None)
            if springs is not None:
                assert_allclose(getattr(got, key).frequency, springs.frequency, rtol=1e-5)
                assert_allclose(getattr(got, key).damping_ratio, springs.damping_ratio, rtol=1e-5)


def test_sensor_errors_and_clocks_are_in_the_replay(tmp_path):
    write_model(diagnosis(BIAS, LATE), evidence(), tmp_path)
    listed = tomllib.loads((tmp_path / "imus.toml").read_text())["effect"]
    assert [(e["name"], e["replayed"]) for e in listed] == [("gyro_bias", True), ("time_offset", True)]
    recording, _ = replay(tmp_path, np.random.default_rng(0))
    truth = truth_of(rig_of(recording, MOUNTS))
    sensor, imu = truth.sensor("imu2"), recording.imu("imu2")
    late = slice(50, None)
    want = np.stack([np.interp(STAMPS - 0.02, truth.time, x) for x in sensor.gyro.T], axis=1) + np.array(
        [0.1, -0.2, 0.3]
    )
    assert_allclose(imu.gyro[late], want[late], atol=1e-3)  # the truth read linearly at 400 Hz
    untouched = np.stack([np.interp(STAMPS, truth.time, x) for x in truth.sensor("imu1").gyro.T], axis=1)
    assert_allclose(recording.imu("imu1").gyro, untouched, atol=1e-3)


def test_a_mount_pose_moves_the_mount_and_a_heavy_com_keeps_its_answer():
    shown = evidence()
    turned = {
        "rotation": Parameter([0.0, 0.1, 0.0], np.zeros(3), "rad"),
        "translation": Parameter([0, 0, 0.01], np.zeros(3), "m"),
    }
    finding = Finding("mount_pose", "imu1", 0.9, turned, Interval(1.0, (0.0, 2.0)))
    mount = rig_of(shown.recording, MOUNTS, (finding,)).mounts[0]
    assert_allclose(mount.position, MOUNTS["imu1"].position + np.array([0, 0, 0.01]))
    between = rotations.multiply(rotations.conjugate(MOUNTS["imu1"].quaternion), mount.quaternion)
    assert_allclose(rotations.log(between), [0, 0.1, 0], atol=1e-12)
    heavy = replace(ROCKING, parameters={**ROCKING.parameters, "com": Parameter([0, 0, 0.03], np.zeros(3), "m")})
    rig = rig_of(shown.recording, MOUNTS, (heavy,))
    compile_model(rig)  # a body that MuJoCo knows
    mount = rig.mounts[0]
    assert_allclose(mount.com / mount.gyration**2, np.array([0, 0, 0.03]) / 0.015**2)


def test_a_measured_place_is_followed_and_a_fixed_base_stays():
    rig = rigs.hinge(mounts=tuple(Mount(p.position, p.quaternion) for p in MOUNTS.values()))
    motion = moved()
    time = motion.time
    place = movement()(time + 0.3).position
    truth = truth_of_motion(rig, moved(position=place, force=None), 0.0, 2.0, RATE)
    other = truth_of_motion(rig, motion, 0.0, 2.0, RATE)
    some = STAMPS[:190]
    for name in MOUNTS:
        for a, b in zip(read_by(truth, 0.0, some, name, ()), read_by(other, 0.0, some, name, ()), strict=True):
            assert_allclose(a, b, atol=1e-3)  # quintic splines through a 1.5 Hz motion at 100 Hz, of 10 m/s^2


def test_a_declared_body_swings_with_moments_that_a_body_can_have():
    shown = evidence().recording
    heavy = Body(1.2, np.array([0.1, 0, 0]), np.array([0.01, 0.03, 0.03]))
    assert rig_of(replace(shown, body=heavy), MOUNTS).segments[1].mass == 1.2
    flat = Body(1.2, np.array([0.1, 0, 0]), np.array([0.01, 0.01, 0.03]))
    segment = rig_of(replace(shown, body=flat), MOUNTS).segments[1]
    assert segment.mass == 1.2
    assert segment.inertia == pytest.approx([0.015, 0.015, 0.03])


def test_what_is_not_likely_is_not_played(tmp_path):
    """Its motion is recovered without it; what has no name is played whatever is thought of it."""
    sure = finding("gyro_bias", "imu1", {"bias": [0.01, 0.0, 0.0]})
    doubted = replace(finding("skin_sliding", "imu2", {"slide": [0.01, 0, 0], "twist": [0.0, 0, 0.1]}), confidence=0.2)
    nameless = Finding("unknown", "imu2", 0.2, {}, Interval(1.0, (0.5, 2.0)))
    write_model(diagnosis(sure, doubted, nameless), evidence(), tmp_path)
    told = load_toml(tmp_path / SENSORS_FILE)["effect"]
    assert [(e["name"], e["at"]) for e in told] == [("gyro_bias", "imu1"), ("unknown", "imu2")]
    assert not read_model(tmp_path).rig.mounts[1].slides


def test_an_encoder_alone_is_replayed_and_a_single_second_imu_keeps_its_place(tmp_path):
    shown = evidence()
    encoder = Encoder("hinge", STAMPS, np.zeros(STAMPS.size))
    alone = replace(
        shown,
        recording=Recording("rec", "hinge", encoders=(encoder,)),
        mounts={},
        levels=(Level("encoder.angle", "rad", None, 1e-12, 1e-12),),
    )
    write_model(diagnosis(), alone, tmp_path)
    recording, _ = replay(tmp_path, np.random.default_rng(0))
    assert not recording.imus
    # the truth read linearly at 500 Hz
    assert_allclose(recording.encoders[0].angle, movement()(STAMPS + 0.3).angle, atol=1e-4)
    second = {"imu2": MOUNTS["imu2"]}
    rig = rig_of(replace(shown.recording, imus=shown.recording.imus[1:]), second)
    assert_allclose(rig.mounts[1].position, MOUNTS["imu2"].position)


@pytest.mark.parametrize("declared", [None, 0.02])
def test_a_triple_of_which_no_sample_counts_has_its_declared_noise(declared, tmp_path):
    """An accelerometer that clips throughout: the fit says nothing of its noise."""
    shown = evidence()
    imus = tuple(replace(i, accel_noise_std=declared) for i in shown.recording.imus)
    levels = tuple(level for level in shown.levels if level.group != "imu2.accel")
    shown = replace(shown, recording=replace(shown.recording, imus=imus), levels=levels)
    write_model(diagnosis(), shown, tmp_path)
    told = {i["name"]: i["accel_noise_std"] for i in load_toml(tmp_path / "imus.toml")["imu"]}
    assert told == {"imu1": 1e-12, "imu2": declared or 0.0}
    recording, _ = replay(tmp_path, np.random.default_rng(0))
    assert np.isfinite(recording.imus[1].accel).all()


def test_run_replays_a_model_folder(tmp_path):
    write_model_in = tmp_path / "model"
    write_model_in.mkdir()
    write_model(diagnosis(SOFT), evidence(), write_model_in)
    done = run_scenario(str(write_model_in), tmp_path / "out", "olsson2020")
    assert (tmp_path / "out" / "recording" / "recording.toml").exists()
    assert (tmp_path / "out" / "run.rrd").exists()
    assert done.score is not None


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        ("imus.toml", "format = 2", "expected format = 1, got 2"),
        ("imus.toml", "format = 1", "key 'rig': expected a text, got None"),
        ("hinge.xml", "<mujoco/>", "expected a body 'segment1'"),
        ("hinge.xml", "<mujoc", "expected XML, got: "),
        ("motion.csv", "time,qw\n0,1\n", "qx"),
    ],
)
def test_a_broken_model_folder_is_one_line(file, text, message, tmp_path):
    write_model(diagnosis(), evidence(), tmp_path)
    (tmp_path / file).write_text(text)
    with pytest.raises(InputError, match=message) as error:
        replay(tmp_path, np.random.default_rng(0))
    assert "\n" not in str(error.value)


UNKNOWN = Finding("unknown", "imu2", 0.9, {}, Interval(9.0, (8.0, 9.0)))


def strange(*fitted):
    shown = evidence()
    return replace(shown, motion=replace(shown.motion, fitted=fitted))


def test_what_has_no_name_plays_as_the_signal_that_was_fitted(tmp_path):
    time = np.arange(-0.1, SECONDS + 0.1, 0.02)
    wave = np.stack([np.sin(3 * time), 0 * time, np.cos(2 * time)], axis=1)
    terms = [FittedEffect("unknown", "imu2", time=time, signals={part: wave}) for part in ("gyro", "accel", "gyro")]
    said = replace(diagnosis(BIAS), verdict="partly explained", findings=(BIAS, UNKNOWN))
    for folder, fitted in (("with", terms), ("without", [])):
        (tmp_path / folder).mkdir()
        write_model(said, strange(*fitted), tmp_path / folder)
    listed = tomllib.loads((tmp_path / "with" / "imus.toml").read_text())["effect"]
    assert listed[1] == {
        "name": "unknown", "at": "imu2", "replayed": True, "signal": "unknown_imu2.csv", "parameters": {}
    }  # fmt: skip
    told, plain = (replay(tmp_path / f, np.random.default_rng(0))[0].imu("imu2") for f in ("with", "without"))
    added = np.stack([np.interp(STAMPS, time, x) for x in wave.T], axis=1)
    assert_allclose(told.gyro - plain.gyro, 2 * added, atol=1e-6)  # two terms; digits of the tables
    assert_allclose(told.accel - plain.accel, added, atol=1e-6)
    listed = tomllib.loads((tmp_path / "without" / "imus.toml").read_text())["effect"]
    assert listed[1]["replayed"] is False  # it was seen to be there, and no signal was fitted


def test_a_filter_plays_on_the_channels_that_it_was_fitted_on(tmp_path):
    slow = Finding("low_pass", "imu2", 0.9, {"cutoff": Parameter(5.0, 0.1, "Hz")}, Interval(9.0, (8.0, 9.0)))
    write_model(diagnosis(slow), strange(FittedEffect("low_pass", "imu2", "gyro", {"channels": ("gyro",)})), tmp_path)
    imu = replay(tmp_path, np.random.default_rng(0))[0].imu("imu2")
    sensor = truth_of(rig_of(evidence().recording, MOUNTS)).sensor("imu2")
    accel, gyro = (np.stack([np.interp(STAMPS, np.arange(len(x)) / 400.0, c) for c in x.T], axis=1) for x in (
        sensor.specific_force, low_pass(sensor.gyro, 1 / 400.0, 5.0)
    ))  # fmt: skip
    late = STAMPS > 0.5  # a filter of 5 Hz forgets its start in 0.2 s
    assert_allclose(imu.accel, accel, atol=1e-2)  # the truth read linearly at 400 Hz
    assert_allclose(imu.gyro[late], gyro[late], atol=2e-3)
    assert np.abs(gyro - sensor.gyro[::4]).max() > 0.1


def test_the_numbers_that_no_report_names_are_played(tmp_path):
    stop = Finding("end_stop", "joint", 0.9, {"angle": Parameter(0.7, 0.01, "rad")}, Interval(9.0, (8.0, 9.0)))
    values = {"stiffness": np.array(40.0), "damping": np.array(0.2)}
    write_model(diagnosis(stop), strange(FittedEffect("end_stop", "joint", values=values)), tmp_path)
    read = read_rig(tmp_path / "hinge.xml", "hinge").stop
    assert read is not None
    assert (read.angle, read.stiffness, read.damping) == pytest.approx((0.7, 40.0, 0.2), rel=1e-4)  # the file's digits
    listed = tomllib.loads((tmp_path / "imus.toml").read_text())["effect"]
    assert listed[0]["parameters"] == {"stiffness": 40.0, "damping": 0.2, "angle": 0.7}


def test_samples_tell_whether_lost_ones_are_held(tmp_path):
    shown = evidence()
    rng = np.random.default_rng(0)
    gyro, accel = rng.standard_normal((2, STAMPS.size, 3))
    kept = np.maximum.accumulate(np.where(rng.uniform(size=STAMPS.size) < 0.3, 0, np.arange(STAMPS.size)))
    first, second = shown.recording.imus
    imus = replace(first, gyro=gyro, accel=accel), replace(second, gyro=gyro[kept], accel=accel[kept])
    found = [
        Finding("dropouts", imu, 0.9, {"fraction": Parameter(0.3, 0.01, "1")}, Interval(9.0, (8.0, 9.0)))
        for imu in ("imu1", "imu2")
    ]
    write_model(diagnosis(*found), replace(shown, recording=replace(shown.recording, imus=imus)), tmp_path)
    listed = tomllib.loads((tmp_path / "imus.toml").read_text())["effect"]
    assert [e["mode"] for e in listed] == ["missing", "held"]
    recording, _ = replay(tmp_path, np.random.default_rng(0))
    assert 0.6 * STAMPS.size < recording.imus[0].time.size < 0.8 * STAMPS.size
    assert 0.2 < np.mean(np.all(np.diff(recording.imus[1].gyro, axis=0) == 0, axis=1)) < 0.4


@pytest.mark.parametrize(
    ("name", "numbers", "message"),
    [
        (
            "low_pass",
            "cutoff = 0.0",
            r"effect\[0\], key 'parameters.cutoff': expected numbers from 0.001 to 1e\+06, got",
        ),
        ("quantisation", "step = 0.0", r"key 'parameters.step': expected numbers from 1e-09"),
        ("dropouts", "fraction = 1.0", r"key 'parameters.fraction': expected numbers from 0 to 0.9, got \[1.0\]"),
        ("backlash", "gap = 0.1", r"effect\[0\], key 'parameters': expected 'range' of backlash, got none"),
        ("saturation", "limit = [1.0, 2.0]", r"key 'parameters.limit': expected 1 of saturation, got 2"),
    ],
)
def test_numbers_that_no_law_has_are_one_line(name, numbers, message, tmp_path):
    write_model(diagnosis(), evidence(), tmp_path)
    path, at = tmp_path / "imus.toml", "joint" if name == "backlash" else "imu1"
    path.write_text(f"{path.read_text()}\n[[effect]]\nname = '{name}'\nat = '{at}'\n[effect.parameters]\n{numbers}\n")
    with pytest.raises(InputError, match=message) as error:
        replay(tmp_path, np.random.default_rng(0))
    assert "\n" not in str(error.value)
