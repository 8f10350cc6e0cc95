"""A diagnosis made by hand: as JSON and back, as a page, as a Rerun file."""

import copy
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from rerun.chunk import RrdReader
from scipy.signal import lfilter

from imubench.commands.work.diagnose import read_tolerance
from imubench.diagnosis.evidence import Comparison, Evidence, Level, Played, Pose, Trace
from imubench.diagnosis.report.rerun_log import log_diagnosis
from imubench.diagnosis.result import (
    CHANNEL_UNIT,
    Change,
    Diagnosis,
    Finding,
    FitQuality,
    Interval,
    Move,
    Noise,
    Parameter,
    Rejected,
    Unseen,
    Where,
)
from imubench.diagnosis.result_file import as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.errors import InputError
from imubench.recording import Imu, Recording
from imubench.reference import Reference
from imubench.rotations import exp

CONTRACT = """
{"format": 1, "recording": "name", "rig": "hinge",
 "verdict": "explained", "alarm": true, "tolerance": {"deg": 0.5, "mm": 5.0},
 "misfit": {"nominal": 4.71, "explained": 1.01, "unit": "residual power over noise power, 1 = only noise"},
 "where": [{"at": "imu2", "channels": {"acc_x": 0.61, "acc_z": 0.33}, "bands_hz": [[9.0, 16.0]],
            "windows_s": [[12.4, 18.9]], "depends_on": "hinge reversals", "share": 0.97}],
 "findings": [{"effect": "soft_mount", "at": "imu2", "confidence": 0.98,
               "parameters": {"frequency": {"value": [11.2], "std": [0.1], "unit": "Hz"}},
               "heldout_gain": {"value": 10432.0, "ci": [9800.0, 11000.0], "unit": "nat"},
               "equivalent": [{"effect": "rocking_mount", "at": "imu2", "heldout_gain": 10410.0}],
               "separate_by": "20 s of on-axis spin at 2 rad/s: expected log Bayes factor 40",
               "moves": {"joint_axis": {"value": [7.6, 3.6], "unit": "deg"},
                         "hinge_angle": {"value": 0.9, "unit": "deg RMS"}},
               "material": true}],
 "rejected": [{"effect": "low_pass", "at": "imu2", "heldout_gain": -900.0}],
 "noise": {"imu1.gyro": {"std": 0.002, "unit": "rad/s", "source": "declared"}},
 "fit": {"heldout": {"before": 4.9, "after": 1.02},
         "left_out_channel": {"before": {"imu2.acc_x": 3.1}, "after": {"imu2.acc_x": 1.1},
                              "unit": "RMS error over noise std"},
         "reference": {"before": {"hinge_angle": 0.051}, "after": {"hinge_angle": 0.008}, "unit": "rad RMS"}},
 "model": "model/hinge.xml", "seconds": 21.4}
"""
TIME = np.arange(6000) / 100
WHERE = Where("imu2", {"acc_x": 0.61, "acc_z": 0.33}, ((9.0, 16.0),), ((12.4, 18.9),), "hinge reversals", 0.97)


def diagnosis(**changes):
    """The one of the contract's example."""
    parts = {
        "recording": "name",
        "rig": "hinge",
        "verdict": "explained",
        "misfit": (4.71, 1.01),
        "where": (WHERE,),
        "findings": (
            Finding(
                "soft_mount",
                "imu2",
                0.98,
                {"frequency": Parameter([11.2], [0.1], "Hz")},
                Interval(10432, (9800, 11000)),
                (Rejected("rocking_mount", "imu2", 10410),),
                "20 s of on-axis spin at 2 rad/s: expected log Bayes factor 40",
                moves={"joint_axis": Move([7.6, 3.6], "deg"), "hinge_angle": Move(0.9, "deg RMS")},
            ),
        ),
        "noise": {"imu1.gyro": Noise(0.002, "rad/s", "declared")},
        "rejected": (Rejected("low_pass", "imu2", -900),),
        "fit": FitQuality(
            (4.9, 1.02),
            Change({"imu2.acc_x": 3.1}, {"imu2.acc_x": 1.1}, CHANNEL_UNIT),
            Change({"hinge_angle": 0.051}, {"hinge_angle": 0.008}, "rad RMS"),
        ),
        "model": "model/hinge.xml",
        "seconds": 21.4,
    }
    return Diagnosis(**(parts | changes))


def ringing(drive, frequency=11.2, damping=0.06, rate=100.0):
    """A resonance's answer to a drive (n,), of its own size."""
    w = 2 * np.pi * frequency / rate
    r = np.exp(-damping * w)
    x = lfilter([0, w**2], [1, -2 * r * np.cos(w), r**2], drive)
    return x - drive


def evidence(name="name", spoiled=(12.4, 18.9)):
    """A hinge whose second IMU rings on its mount while the hinge is moved quickly."""
    rng = np.random.default_rng(3)
    quick = np.clip(np.minimum(TIME - spoiled[0], spoiled[1] - TIME) / 0.4, 0, 1)
    angle = 0.5 * np.sin(2 * np.pi * 0.4 * TIME) + 0.25 * quick * np.sin(2 * np.pi * 2.6 * TIME) ** 3
    turn = np.stack([0.4 * np.sin(1.1 * TIME), 0.5 * np.sin(0.7 * TIME), 0.3 * np.sin(0.5 * TIME)], axis=1)
    q1 = exp(turn)
    force = np.gradient(np.gradient(angle, TIME), TIME) * 0.1
    imus, traces, wrong = [], [], {}
    for at in ("imu1", "imu2"):
        noise = {"gyro": 0.005, "accel": 0.03}
        clean = {"gyro": np.gradient(turn, TIME, axis=0), "accel": np.array([0, 0, 9.81]) + 0.3 * turn}
        left = {part: sigma * rng.normal(size=(TIME.size, 3)) for part, sigma in noise.items()}
        spoil = {part: np.zeros((TIME.size, 3)) for part in noise}
        if at == "imu2":
            clean["accel"] = clean["accel"] + force[:, None] * [0.9, 0.05, 0.6]
            spoil["accel"] = ringing(force)[:, None] * [0.35, 0.01, 0.25]
            spoil["gyro"] = ringing(force)[:, None] * [0.002, 0.012, 0.001]
        measured = {part: clean[part] + spoil[part] + left[part] for part in noise}
        imus.append(
            Imu(at, TIME, measured["gyro"], measured["accel"], 100.0, 0.005, 0.03,
                mount_position=[-0.1 if at == "imu1" else 0.1, 0, 0.03])
        )  # fmt: skip
        for part, channels, unit in (("gyro", "gyr", "rad/s"), ("accel", "acc", "m/s^2")):
            names = tuple(f"{channels}_{a}" for a in "xyz")
            traces.append(Trace(at, part, names, unit, TIME, left[part] + spoil[part], noise[part], left[part]))
        wrong[at] = (clean["accel"], spoil["accel"], measured["accel"])
    recording = Recording(name, "hinge", tuple(imus))
    clean, spoil, measured = wrong["imu2"]
    some = (TIME >= 12) & (TIME < 20)
    compared = Comparison(
        "imu2.acc_x", "m/s^2", TIME[some], measured[some, 0], clean[some, 0], (clean + spoil)[some, 0], 0.03
    )
    motion = Played(TIME, q1, np.zeros((TIME.size, 3)), angle)
    return Evidence(
        recording,
        tuple(traces),
        motion,
        {i.name: Pose(i.mount_position, i.mount_quaternion) for i in imus},
        tuple(
            Level(f"{at}.{part}", unit, sigma, sigma, 1.1 * sigma)
            for at in ("imu1", "imu2")
            for part, unit, sigma in (("gyro", "rad/s", 0.005), ("accel", "m/s^2", 0.03))
        ),
        motion_before=motion,
        heldout_s=((12.0, 20.0), (40.0, 48.0)),
        comparisons=((compared,),),
        notes=("A spline motion and the mounts were fitted to every sample.",),
    )


def kinds(value):
    """The structure of JSON: keys and types, whole numbers counted as numbers."""
    if isinstance(value, dict):
        return {key: kinds(item) for key, item in value.items()}
    if isinstance(value, list):
        return [kinds(item) for item in value]
    return "number" if isinstance(value, int | float) else type(value).__name__


def test_json_is_the_contracts_example_key_by_key():
    written = json.loads(json.dumps(as_dict(diagnosis()), allow_nan=False))
    assert list(written) == list(json.loads(CONTRACT))
    assert kinds(written) == kinds(json.loads(CONTRACT))
    assert written == json.loads(CONTRACT)


def test_scalars_and_matrices_keep_their_shape():
    parameters = {
        "limit": Parameter(4.0, 0.1, "m/s^2"),
        "matrix": Parameter(np.eye(3), np.full((3, 3), 0.1), "1"),
    }
    finding = Finding("saturation", "imu1", 0.9, parameters, Interval(1.0, (0.0, 2.0)))
    written = as_dict(diagnosis(findings=(finding,)))["findings"][0]["parameters"]
    assert written["limit"]["value"] == 4.0
    assert written["matrix"]["value"] == np.eye(3).tolist()


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"verdict": "no mismatch", "findings": (), "where": ()},
        {
            "verdict": "unexplained",
            "findings": (Finding("unknown", "imu2", 0.8, {}, Interval(3.0, (1.0, 5.0)), where=WHERE),),
        },
        {"verdict": "unobservable", "findings": (), "unseen": (Unseen("friction", "a free swing"),)},
        {"moves": {"joint_axis": Move([7.9, 3.6], "deg"), "hinge_angle": Move(1.1, "deg RMS")}},
    ],
    ids=["explained", "none", "unknown", "unobservable", "all together"],
)
def test_what_is_read_is_what_was_written(changes, tmp_path):
    one = diagnosis(**changes)
    (tmp_path / "diagnosis.json").write_text(json.dumps(as_dict(one)))
    for place in (tmp_path, tmp_path / "diagnosis.json"):
        assert as_dict(read_diagnosis(place)) == as_dict(one)


BROKEN = [
    ("format", 2, "key 'format': expected 1, got 2"),
    ("verdict", "fine", "unknown verdict 'fine'; known: no mismatch, explained"),
    ("verdict", "no mismatch", "verdict 'no mismatch': expected findings that go with it"),
    ("misfit.nominal", "4", "key 'misfit.nominal': expected a finite number, got '4'"),
    ("where[0].windows_s[0]", [3.0, 1.0], "where.windows_s: expected the lower end first, got 3 and 1"),
    ("where[0].at", "imu9", "unknown where.at 'imu9'; known: imu1, imu2"),
    ("where[0].share", 2.0, "where.share: expected a number from 0 to 1"),
    ("findings[0].parameters.frequency.std", [0.1, 0.1], "expected shape (1,), got (2,)"),
    ("findings[0].parameters.frequency.value", [[1.0], [1.0, 2.0]], "expected rows of equal length"),
    ("findings[0].heldout_gain.ci", [1.0], "key 'findings[0].heldout_gain.ci': expected two numbers, got 1"),
    ("findings", {}, "key 'findings': expected a list, got {}"),
    ("fit.reference.after", {}, "fit.after: expected the keys ['hinge_angle'], got []"),
    ("recording", None, "key 'recording': expected, got none"),
    ("alarm", False, "key 'alarm': expected true, as its findings say, got false"),
    ("alarm", 1, "key 'alarm': expected true or false, got 1"),
    ("tolerance.mm", -1, "diagnosis.tolerance: expected a number from 0 to inf, got -1"),
    ("noise[imu1.gyro].source", "guessed", "unknown noise.source 'guessed'; known: declared, profile, rest, unknown"),
    ("noise[imu1.gyro].std", -1.0, "noise.std: expected a number from 0 to inf, got -1"),
    ("findings[0].material", "yes", "key 'findings[0].material': expected true or false, got 'yes'"),
    ("findings[0].moves.hinge_angle.value", -0.9, "moves.hinge_angle': moves: expected a finite number"),
    ("findings[0].moves.joint_axis.value", [[1.0], 2.0], "expected rows of equal length"),
    ("findings[0].moves.joint_axis.unit", "rad", "expected a unit of deg or mm, got 'rad'"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "value", "message"), BROKEN, ids=[b[0] for b in BROKEN])
def test_a_broken_file_is_one_line_that_says_what_is_wrong(key, value, message, tmp_path):
    content = json.loads(CONTRACT)
    *path, last = [int(k) if k.isdigit() else k for k in re.findall(r"imu\d\.\w+|\w+", key)]
    place = content
    for step in path:
        place = place[step]
    if value is None:
        del place[last]
    else:
        place[last] = copy.deepcopy(value)
    path = tmp_path / "diagnosis.json"
    path.write_text(json.dumps(content))
    with pytest.raises(InputError) as error:
        read_diagnosis(path)
    assert message in str(error.value)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "expected JSON"),
        ('{"format": NaN}', "not finite"),
        ("[]", "expected an object"),
        (None, "got nothing of that name"),
    ],
)
def test_no_diagnosis_at_all_is_one_line(text, message, tmp_path):
    path = tmp_path / "diagnosis.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=message) as error:
        read_diagnosis(path)
    assert "\n" not in str(error.value)


def test_a_file_without_the_keys_that_were_added_is_read(tmp_path):
    """What nothing is known of counts as material."""
    content = json.loads(CONTRACT)
    for key in ("alarm", "tolerance", "noise"):
        del content[key]
    for key in ("moves", "material"):
        del content["findings"][0][key]
    (tmp_path / "diagnosis.json").write_text(json.dumps(content))
    old = read_diagnosis(tmp_path)
    assert (old.alarm, old.tolerance, old.noise, old.findings[0].moves) == (True, (0.5, 5.0), {}, {})


def finding(effect, confidence, material):
    return Finding(effect, "imu1", confidence, {}, Interval(0.0, (0.0, 0.0)), material=material)


@pytest.mark.parametrize(
    ("effect", "confidence", "material", "alarm"),
    [
        ("gyro_bias", 0.5, True, True),
        ("gyro_bias", 0.49, True, False),
        ("gyro_bias", 0.96, False, False),
        ("unknown", 0.3, True, True),
        ("unknown", 0.96, False, False),
    ],
)
def test_an_alarm_is_what_is_sure_and_matters_or_has_no_name_and_matters(effect, confidence, material, alarm):
    found = finding(effect, confidence, material)
    verdict = "no mismatch" if confidence < 0.5 else "unexplained" if effect == "unknown" else "explained"
    assert diagnosis(findings=(found,), verdict=verdict).alarm is alarm


def test_nothing_is_explained_beside_a_noise_that_nobody_knows():
    nobody = {"imu1.gyro": Noise(0.002, "rad/s", "declared"), "imu2.accel": Noise(0.05, "m/s^2", "unknown")}
    with pytest.raises(InputError, match=r"no noise known of imu2\.accel"):
        diagnosis(noise=nobody)
    partly = diagnosis(noise=nobody, verdict="partly explained")
    assert partly.noise_unknown == ("imu2.accel",)
    with pytest.raises(InputError, match="expected findings that go with it"):
        diagnosis(verdict="partly explained")


@pytest.mark.parametrize("text", ["1", "1,2,3", "a,b", "-1,5", "nan,5", "1,inf", ""])
def test_a_tolerance_that_is_none_is_one_line(text):
    with pytest.raises(InputError, match=r"^--tolerance: expected") as error:
        read_tolerance(text)
    assert "\n" not in str(error.value)
    assert read_tolerance("0.2, 3") == (0.2, 3.0)


def test_what_was_added_to_a_finding_is_written_and_read(tmp_path):
    one = replace(diagnosis().findings[0], share=0.93, unseen=("translation along the hinge axis",))
    written = as_dict(diagnosis(findings=(one,)))
    assert written["findings"][0]["share"] == 0.93
    (tmp_path / "diagnosis.json").write_text(json.dumps(written))
    back = read_diagnosis(tmp_path).findings[0]
    assert (back.share, back.unseen) == (one.share, one.unseen)
    assert {"share", "unseen"}.isdisjoint(as_dict(diagnosis())["findings"][0])  # there only where they are known
    with pytest.raises(InputError, match=r"finding\.share: expected a number from 0 to 1, got 1\.2"):
        replace(one, share=1.2)


def test_numbers_that_are_not_finite_are_refused_when_made():
    with pytest.raises(InputError, match="finite"):
        Parameter([np.nan], [1.0], "1")
    with pytest.raises(InputError, match="finite"):
        diagnosis(misfit=(np.inf, 1.0))
    with pytest.raises(InputError, match="expected shape"):
        Trace("imu1", "gyro", ("gyr_x",), "rad/s", TIME, np.zeros((5, 1)), 1.0)


def test_the_rerun_file_holds_motion_residuals_and_windows(tmp_path):
    one, shown = diagnosis(), evidence()
    seen = Reference(TIME[::4], hinge_angle=shown.motion.hinge_angle[::4] + 0.01)
    log_diagnosis(tmp_path / "diagnosis.rrd", one, shown, seen)
    chunks = RrdReader(str(tmp_path / "diagnosis.rrd")).stream().collect()

    def read(path, component):
        table = chunks.reader(index="sim_time", contents=path).to_pandas()
        name = next(c for c in table.columns if c.endswith(component))
        rows = table[table[name].notna()]
        return rows["sim_time"].astype("int64").to_numpy() / 1e9, np.array([list(v) for v in rows[name]])

    for trace in shown.traces:
        for side, z in (("before", trace.whitened), ("after", trace.whitened_after)):
            time, values = read(f"/residual/{trace.at}/{trace.part}/{side}", "Scalars:scalars")
            np.testing.assert_array_equal(time, np.round(TIME, 9))
            np.testing.assert_array_equal(values, z)
    np.testing.assert_array_equal(read("/hinge_angle/after", "scalars")[1][:, 0], shown.motion.hinge_angle)
    np.testing.assert_array_equal(read("/hinge_angle/reference", "scalars")[1][:, 0], seen.hinge_angle)
    time, turns = read("/world/segment2", "Transform3D:quaternion")
    assert time[-1] == TIME[-1]
    assert np.ptp(turns.reshape(time.size, 4), axis=0).max() > 0.1  # it moves
    np.testing.assert_allclose(read("/windows/held_out", "state")[0], [12, 20, 40, 48])
    np.testing.assert_allclose(read("/windows/imu2", "state")[0], [12.4, 18.9])
