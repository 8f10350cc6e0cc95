"""What an undisturbed recording says of its sensors, taken over into the diagnosis of another one."""

from dataclasses import replace

import numpy as np
import pytest

from imubench import format1
from imubench.answers import write_json
from imubench.diagnosis.on_disk import diagnose_on_disk
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.report import words
from imubench.diagnosis.result import (
    Baseline,
    Diagnosis,
    Doubt,
    Finding,
    FitQuality,
    Interval,
    Noise,
    Own,
    Parameter,
    SensorErrors,
)
from imubench.diagnosis.result_file import as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.diagnosis.sensor_errors.baseline import Learned, check_same_sensors, check_usable, whole
from imubench.diagnosis.sensor_errors.own_errors import samplewise
from imubench.diagnosis.simulation.model_folder import replay
from imubench.effects import EFFECTS
from imubench.effects.effect import Reading
from imubench.effects.known import KnownErrors
from imubench.errors import InputError
from imubench.jets import Jet
from imubench.proof.case import make_case
from imubench.recording import Imu, Recording
from tests import command

GAIN = Interval(0.0, (0.0, 0.0))
OWN = {
    "gyro_bias": {"bias": Parameter([0.03, -0.02, 0.01], [1e-3, 2e-3, 3e-3], "rad/s")},
    "accel_scale": {"scale": Parameter([0.01, 0.0, -0.02], [0.001] * 3, "1")},
}


def sensor(at: str = "imu1", rate: float = 50.0, **ranges: float) -> SensorErrors:
    """Return two errors of a sensor whose numbers 0 and 3 go together."""
    correlation = np.eye(6)
    correlation[0, 3] = correlation[3, 0] = 0.5
    return SensorErrors(at, rate, ranges, tuple(Own(name, at, p) for name, p in OWN.items()), correlation)


def said(*findings: Finding, **more) -> Diagnosis:
    """Return a diagnosis with some findings."""
    named = any(f.confidence >= 0.5 for f in findings)
    verdict = "explained" if named else "no mismatch"
    quality = FitQuality((1.0, 1.0))
    return Diagnosis("still", "free", verdict, (1.0, 1.0), (), findings, (), quality, "", 1.0, **more)


def recorded(
    name: str = "moved", rate: float = 50.0, rig: str = "free", imus: tuple[str, ...] = ("imu1",), **more: float
) -> Recording:
    """Return a second of IMUs that do not move."""
    time = np.arange(0.0, 1.0, 1 / rate)
    at_rest = np.tile([0.0, 0.0, 9.81], (time.size, 1))
    return Recording(name, rig, tuple(Imu(i, time, 0 * at_rest, at_rest, rate, **more) for i in imus))


# The law


def test_known_errors_are_those_of_their_effects_side_by_side():
    rng = np.random.default_rng(1)
    effects = [e for e in EFFECTS.values() if samplewise(e)]
    k = sum(p.width for e in effects for p in e.parameters)
    root = rng.normal(size=(k, k)) / k
    mean = 0.01 * rng.normal(size=k)
    known = KnownErrors(effects, mean, root @ root.T)
    u = rng.normal(size=k)
    reading = Reading(Jet(rng.normal(size=(5, 3))), Jet(10 * rng.normal(size=(5, 3))), Jet(np.zeros((5, 1))))
    got = known.error(reading, {"u": Jet(u[None])})
    numbers, first = mean + known.root @ u, 0
    gyro, accel = np.zeros((5, 3)), np.zeros((5, 3))
    for effect in effects:
        own = {}
        for p in effect.parameters:
            own[p.name], first = Jet(numbers[None, first : first + p.width]), first + p.width
        added = effect.error(reading, own)
        gyro = gyro + (0.0 if added.gyro is None else added.gyro.value)
        accel = accel + (0.0 if added.accel is None else added.accel.value)
    assert first == k == 33  # two biases and scales of 3, two misalignments of 6, a g-sensitivity of 9
    np.testing.assert_allclose(got.gyro.value, gyro, atol=1e-12)  # the same sums in another order
    np.testing.assert_allclose(got.accel.value, accel, atol=1e-12)


def test_every_effect_of_a_sensor_has_one_parameter_and_says_how_far_it_goes():
    own = {e.name: e for e in EFFECTS.values() if e.of_the_sensor is not None}
    assert {"gyro_bias", "accel_scale", "g_sensitivity", "quantisation", "accel_noise", "low_pass"} <= own.keys()
    assert not {"mount_pose", "soft_mount", "saturation", "time_offset", "gyro_drift", "dry_friction"} & own.keys()
    for effect in own.values():
        assert len(effect.parameters or effect.found) == 1
        assert np.all(effect.of_the_sensor.of(np.ones(1)) > 0)


# What is taken over


def test_what_is_known_is_as_wide_as_its_spread_and_the_time_between():
    (h,) = Learned.of(said(sensors=(sensor(),))).hypotheses
    covariance = h.effect.root @ h.effect.root.T
    bias, scale = (EFFECTS[name].of_the_sensor.std for name in OWN)
    assert covariance[0, 0] == pytest.approx(1e-3**2 + bias**2)
    assert covariance[3, 3] == pytest.approx(1e-3**2 + scale**2)
    assert covariance[0, 3] == pytest.approx(0.5 * 1e-3 * 1e-3)  # what changes in between is no part of it
    np.testing.assert_allclose(h.effect.expected, [0.03, -0.02, 0.01, 0.01, 0.0, -0.02])
    taken = Learned.of(said(sensors=(sensor(),))).record
    np.testing.assert_allclose(taken.taken_over[0].parameters["bias"].std, np.hypot([1e-3, 2e-3, 3e-3], bias))
    assert words.baseline(taken).startswith("Known from the baseline still")
    assert not taken.doubt and "may be wrong" not in words.baseline(taken)


def test_a_baseline_that_was_stopped_or_is_doubted_is_said_to_be(tmp_path):
    stopped = said(sensors=(sensor(),), stopped="time limit of 5 s of processor time", not_tried=("the rest",))
    doubted = replace(
        said(Finding("gyro_bias", "imu1", 0.9, {}, Interval(9.0, (8.0, 10.0))), sensors=(sensor(),)),
        verdict="partly explained",
        doubts=(Doubt("gyro_bias at imu1", "the halves disagree"),),
    )
    for one, why in (
        (stopped, "it was stopped by the time limit of 5 s of processor time"),
        (doubted, "its model is doubted: gyro_bias at imu1: the halves disagree"),
    ):
        taken = Learned.of(one).record
        assert words.baseline(taken).endswith(f"What that says of the sensors may be wrong: {why}.")
        again = replace(said(), baseline=taken)
        write_json(tmp_path / "diagnosis.json", as_dict(again))
        assert read_diagnosis(tmp_path).baseline.doubt == why


def noise(std: float, error: float = 0.001) -> Finding:
    return Finding("gyro_noise", "imu1", 0.99, {"std": Parameter(std, error, "rad/s")}, GAIN)


@pytest.mark.parametrize(("std", "new"), [(0.022, False), (0.028, False), (0.035, True)])
def test_noise_above_the_declared_is_new_where_it_differs(std, new):
    """0.02 goes by 0.003 from one recording to the next: 0.0095 and more is beyond three standard deviations."""
    learned = Learned.of(said(noise(0.02), sensors=(sensor(),)))
    assert [f.parameters["std"].value for f in learned.new([noise(std)])] == [std] * new


def test_rounding_of_another_triple_and_knocks_are_new():
    def rounded(unit):
        return Finding("quantisation", "imu1", 0.99, {"step": Parameter(0.1, 1e-6, unit)}, GAIN)

    struck = Finding("impacts", "imu1", 0.95, {"times": Parameter([1.0, 2.0], [0.01, 0.01], "s")}, GAIN)
    learned = Learned.of(said(rounded("rad/s"), struck, sensors=(sensor(),)))
    assert learned.new([rounded("rad/s"), rounded("m/s^2"), struck]) == (learned.new([rounded("m/s^2"), struck]))
    assert len(learned.new([rounded("rad/s"), rounded("m/s^2"), struck])) == 2


def test_a_noise_that_the_sensor_showed_at_rest_is_known_in_the_next_recording():
    rest = {"imu1.gyro": Noise(0.002, "rad/s", "rest"), "imu1.accel": Noise(0.1, "m/s^2", "unknown")}
    learned = Learned.of(said(sensors=(sensor(),), noise=rest))
    assert learned.noise.keys() == {"imu1.gyro"}
    now = {"imu1.gyro": Noise(0.002, "rad/s", "rest"), "imu1.accel": Noise(0.05, "m/s^2", "rest")}
    assert learned.known(now)["imu1.gyro"].source == "rest"


def test_a_model_plays_the_sensors_errors_with_the_change_in_them():
    change = Finding("gyro_bias", "imu1", 0.9, {"bias": Parameter([0.01, 0, 0], [1e-3] * 3, "rad/s")}, GAIN)
    spring = Finding("soft_mount", "imu1", 0.9, {}, GAIN)
    d = said(change, spring, sensors=(sensor(),), baseline=Baseline("still", ()))
    played = whole(d)
    assert [f.effect for f in played] == ["soft_mount", "gyro_bias", "accel_scale"]
    np.testing.assert_allclose(played[1].parameters["bias"].value, [0.03, -0.02, 0.01])
    assert whole(replace(d, baseline=None)) == d.findings


# What is refused, and what is written


def test_a_diagnosis_is_read_back_with_what_it_says_of_its_sensors(tmp_path):
    d = said(sensors=(sensor(gyro=35.0),), baseline=Baseline("still", (Own("gyro_bias", "imu1", OWN["gyro_bias"]),)))
    write_json(tmp_path / "diagnosis.json", as_dict(d))
    back = read_diagnosis(tmp_path)
    assert as_dict(back) == as_dict(d)
    check_usable(back, tmp_path)
    check_same_sensors(back, recorded(gyro_range=35.0))


def test_a_matrix_that_is_no_correlation_is_refused():
    good = sensor()
    for wrong in (np.eye(5), np.eye(6) + 0.5 * np.eye(6, k=1), 2 * np.eye(6), 1.5 - 0.5 * np.eye(6)):
        with pytest.raises(InputError, match=r"sensors\.correlation: expected"):
            replace(good, correlation=wrong)


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (recorded(rig="hinge", imus=("imu1", "imu2")), "expected the sensors of moved, imu1, imu2, got imu1"),
        (recorded(rate=100.0), "expected imu1 at 100 Hz, as in moved, got 50 Hz"),
        (recorded(gyro_range=17.0), "expected imu1's gyro to reach 17, got 35"),
    ],
)
def test_other_sensors_are_refused(other, message):
    with pytest.raises(InputError, match=message):
        check_same_sensors(said(sensors=(sensor(gyro=35.0),)), other)


def test_the_same_sensors_on_another_day_are_not():
    check_same_sensors(said(sensors=(sensor(gyro=35.0),)), recorded(rate=50.5, accel_range=160.0))
    check_same_sensors(recorded("still"), recorded())


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ((), "says what its sensors' own errors are"),
        (
            (replace(sensor(), errors=(Own("mount_pose", "imu1", OWN["gyro_bias"]),), correlation=np.eye(3)),),
            "mount_",
        ),
        (
            (replace(sensor(), errors=(Own("gyro_scale", "imu1", OWN["gyro_bias"]),), correlation=np.eye(3)),),
            "expected the parameters",
        ),
    ],
)
def test_a_diagnosis_that_says_nothing_of_its_sensors_is_refused(wrong, message, tmp_path):
    with pytest.raises(InputError, match=message):
        check_usable(said(sensors=wrong), tmp_path)


@pytest.fixture
def folders(tmp_path):
    """Two recordings of other sensors, a diagnosis of another format, and an empty folder."""
    make_case(tmp_path / "rec", "free", (), 1, seconds=6.0, rate=50.0)
    make_case(tmp_path / "hinge", "hinge", (), 1, seconds=6.0, rate=50.0)
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "diagnosis.json").write_text('{"format": 2}')
    (tmp_path / "none").mkdir()
    return tmp_path


@pytest.mark.parametrize(
    ("given", "out", "message"),
    [
        ("old", "out", "key 'format': expected 1, got 2"),
        ("none", "out", r"recording\.toml"),
        ("hinge", "out", "expected the sensors of"),
        ("hinge", "hinge/out", "apart from the input .*hinge"),
    ],
)
def test_bad_baselines_are_refused_and_nothing_is_left(given, out, message, folders):
    with pytest.raises(InputError, match=message):
        diagnose_on_disk(folders / "rec", folders / out, baseline=folders / given)
    assert sorted(p.name for p in folders.iterdir()) == ["hinge", "none", "old", "rec"]


def test_the_command_refuses_a_baseline_in_one_line(folders):
    done = command.here("diagnose", "rec", "--out", "out", "--baseline", "hinge", folder=folders)
    assert (done.code, len(done.err.strip().splitlines())) == (2, 1), done.err
    assert "expected the sensors of" in done.err


# Against recordings of an independent generator

ERRORS = (
    ("gyro_bias", "imu1", {"bias": np.array([0.03, -0.02, 0.015])}),
    ("accel_scale", "imu1", {"scale": np.array([0.03, -0.02, 0.025])}),
)
SECONDS, RATE = 12.0, 50.0


def free_body(folder, seed, *more) -> Recording:
    """Return a free body with a measured pose, moved by a motion of its own, the sensor's errors in it."""
    make_case(folder, "free", (*ERRORS, *more), seed, seconds=SECONDS, rate=RATE)
    return format1.read_recording(folder)


@pytest.fixture(scope="module")
def still(tmp_path_factory) -> Diagnosis:
    return diagnose(free_body(tmp_path_factory.mktemp("baseline") / "still", 3))[0]


def told(found: Diagnosis) -> list[tuple[str, str]]:
    """Return the names that a diagnosis is sure of."""
    return [(f.effect, f.at) for f in found.findings if f.confidence >= 0.5]


@pytest.mark.long
def test_what_a_recording_says_of_its_sensors_holds_the_truth(still):
    assert set(told(still)) == {("gyro_bias", "imu1"), ("accel_scale", "imu1")}
    (sensor,) = still.sensors
    truth = {name: values for name, _, parameters in ERRORS for values in parameters.values()}
    parts = [(truth.get(own.effect, 0.0), p) for own in sensor.errors for p in own.parameters.values()]
    off = sensor.value - np.concatenate([np.broadcast_to(x, p.value.shape).ravel() for x, p in parts])
    # chi-square of 33 numbers: 66 is beyond 99.95 %, and coloured noise is counted in
    assert off @ np.linalg.solve(sensor.covariance, off) < 66


@pytest.mark.long
def test_another_motion_of_the_same_sensor_says_nothing_new(still, tmp_path):
    found, _ = diagnose(free_body(tmp_path / "moved", 5), baseline=still)
    assert (found.verdict, told(found), found.alarm) == ("no mismatch", [], False)
    assert found.misfit[0] < 1.3  # noise with 20 % of coloured power on top is no mismatch
    assert {own.effect for own in found.baseline.taken_over} >= {"gyro_bias", "accel_scale"}
    (sensor,) = found.sensors  # both recordings together know no less than the first and what changes in between
    assert np.all(np.diag(sensor.covariance) < np.diag(still.sensors[0].covariance) + 0.05**2)


@pytest.mark.long
def test_one_more_effect_is_all_that_is_said(still, tmp_path):
    found, _ = diagnose(free_body(tmp_path / "struck", 5, ("impacts", "imu1", None)), baseline=still)
    assert told(found) == [("impacts", "imu1")]


@pytest.mark.long
def test_a_changed_bias_is_said_with_its_change(still, tmp_path):
    change = np.array([-0.05, 0.04, 0.06])
    later = [("gyro_bias", "imu1", {"bias": ERRORS[0][2]["bias"] + change}), ERRORS[1]]
    make_case(tmp_path / "later", "free", later, 5, seconds=SECONDS, rate=RATE)
    found, _ = diagnose(format1.read_recording(tmp_path / "later"), baseline=still)
    assert told(found) == [("gyro_bias", "imu1")]
    bias = found.findings[0].parameters["bias"]
    assert np.all(np.abs(bias.value - change) < 4 * bias.std)  # one in 5,000 such tests is further off
    assert np.all(bias.std < 0.01)  # what a bias may change anyhow is 2.9 mrad/s


@pytest.mark.long
def test_a_recording_is_diagnosed_first_and_written_beside(tmp_path):
    for name, seed in (("still", 3), ("moved", 5)):
        free_body(tmp_path / name, seed)
    done = diagnose_on_disk(tmp_path / "moved", tmp_path / "out", baseline=tmp_path / "still")
    assert told(done.diagnosis) == []
    earlier, later = read_diagnosis(tmp_path / "out" / "baseline"), read_diagnosis(tmp_path / "out")
    assert later.baseline.recording == earlier.recording
    assert set(told(earlier)) == {("gyro_bias", "imu1"), ("accel_scale", "imu1")}
    assert "Known from the baseline" in (tmp_path / "out" / "report.html").read_text()
    again = diagnose_on_disk(tmp_path / "moved", tmp_path / "more", baseline=tmp_path / "out" / "baseline").diagnosis
    assert as_dict(again)["baseline"] == as_dict(later)["baseline"]
    played, _ = replay(tmp_path / "out" / "model", np.random.default_rng(0))
    measured = format1.read_recording(tmp_path / "moved").imus[0]
    off = played.imus[0].accel - measured.accel
    noise = np.sqrt(2) * done.diagnosis.noise["imu1.accel"].std  # that which is played, and that which was measured
    assert np.sqrt(np.median(off**2)) < 2 * noise  # without the scale of 3 % it is 0.3 m/s^2, ten times as much
