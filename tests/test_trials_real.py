"""Effects added to recordings that exist, and judged beside the untouched one."""

import json
from pathlib import Path

import numpy as np
import pytest

from imubench import format1
from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Interval, Parameter
from imubench.errors import InputError
from imubench.proof.added import ADDABLE, add, addable, filtered, quiet_std, read_samples
from imubench.proof.case import make_case
from imubench.proof.sensors import Samples
from imubench.trials.prove import prove
from imubench.trials.real import beside, made_real, questions
from imubench.trials.settings import Settings

SILENT = """
import json, os, pathlib, sys
recording, out = map(pathlib.Path, sys.argv[1:3])
assert len({p.stat().st_mtime for p in recording.iterdir()}) == 1
finding = [{"effect": "unknown", "at": "imu1", "confidence": 0.8, "parameters": {}, "equivalent": [], "separate_by": "",
  "heldout_gain": {"value": 0.0, "ci": [0.0, 0.0], "unit": "nat"}}]
pair = {"before": {}, "after": {}, "unit": ""}
out.mkdir()
(out / "diagnosis.json").write_text(json.dumps({"format": 1, "recording": "recording", "rig": "hinge",
  "verdict": "unexplained", "misfit": {"nominal": 1.0, "explained": 1.0, "unit": ""}, "where": [], "findings": finding,
  "rejected": [], "fit": {"heldout": {"before": 1.0, "after": 1.0}, "left_out_channel": pair, "reference": pair},
  "model": "", "seconds": 0.1}))
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("real") / "walk"
    make_case(folder, "hinge", (), 4, seconds=8.0, name="walk")
    return folder


@pytest.mark.parametrize("name", ADDABLE)
def test_every_effect_changes_its_imu_and_nothing_else(name, recording, tmp_path):
    truth = add(recording, tmp_path / "out", name, "imu2", 7, "strong")
    assert [(e["effect"], e["at"]) for e in truth["effects"]] == [(name, "imu2")]
    json.dumps(truth)
    before, after = (format1.read(folder)[0] for folder in (recording, tmp_path / "out"))
    assert np.allclose(before.imus[0].accel, after.imus[0].accel, atol=1e-7)  # nine digits are written
    one, two = (r.imus[1] for r in (before, after))
    same = len(one.time) == len(two.time) and np.allclose(one.gyro, two.gyro) and np.allclose(one.accel, two.accel)
    assert not same


def test_a_bias_and_an_offset_are_what_their_law_says(recording, tmp_path):
    truth = add(recording, tmp_path / "biased", "accel_bias", "imu1", 7, "medium")
    one, two = (read_samples(folder / "imu1.csv") for folder in (recording, tmp_path / "biased"))
    assert np.allclose(two.accel - one.accel, truth["effects"][0]["parameters"]["bias"], atol=1e-6)  # nine digits
    truth = add(recording, tmp_path / "late", "time_offset", "imu2", 7, "strong")
    offset = truth["effects"][0]["parameters"]["offset"]
    one, two = (read_samples(folder / "imu2.csv") for folder in (recording, tmp_path / "late"))
    whole = slice(20, -20)  # the ends have no neighbour to move in
    rate = np.gradient(one.gyro, one.time, axis=0)[whole]
    slope = np.sum(rate * (two.gyro - one.gyro)[whole]) / np.sum(rate**2)
    assert slope == pytest.approx(-offset, rel=0.15)  # a first-order fit to an offset of a few samples


def test_a_filter_halves_the_power_at_its_cutoff():
    time = np.arange(0, 20, 0.01)
    y = filtered(time, np.sin(2 * np.pi * 5.0 * time)[:, None] * np.ones(3), 5.0)
    assert np.std(y[500:, 0]) == pytest.approx(0.5, rel=0.02)  # 1 / sqrt 2 of an amplitude whose std is 1 / sqrt 2


def test_quiet_windows_tell_the_noise_of_a_moving_sensor():
    rng = np.random.default_rng(0)
    time = np.arange(0, 40, 0.01)
    still = np.sin(0.5 * time)[:, None] * np.ones(3) + 0.02 * rng.standard_normal((len(time), 3))
    assert quiet_std(Samples(time, still, still), still) == pytest.approx(0.02, rel=0.15)  # the quietest tenth is low


def test_questions_repeat_by_seed_and_do_not_tell_by_their_name(recording):
    first, again = (questions(recording.parent, 3, 4) for _ in range(2))
    assert first == again and len(first) == 5
    untouched = [name for name, q in first.items() if not q.effect]
    assert {q.base for q in first.values()} == set(untouched)
    assert len({tuple(n for n, q in questions(recording.parent, s, 4).items() if not q.effect) for s in range(8)}) > 1
    with pytest.raises(InputError, match="expected folders in format 1, got none"):
        questions(recording / "nowhere", 3, 4)


def test_one_clock_cannot_be_late(tmp_path):
    make_case(tmp_path / "one", "pendulum", (), 4, seconds=6.0)
    assert not {"time_offset", "clock_skew"} & {name for name, _ in addable(tmp_path / "one")}


def test_a_noise_of_which_nothing_is_declared_cannot_be_louder(tmp_path):
    noises = {"gyro_noise", "accel_noise"}
    for said in (True, False):
        make_case(tmp_path / str(said), "pendulum", (), 4, seconds=6.0, declare_noise=said)
        assert ({name for name, _ in addable(tmp_path / str(said))} & noises) == (noises if said else set())


def test_an_untouched_recording_is_written_with_the_same_digits(recording, tmp_path):
    asked = questions(recording.parent, 3, 1)
    for name, q in asked.items():
        made_real(q, tmp_path / name)
    touched = next(q for q in asked.values() if q.effect)
    other = "imu1.csv" if touched.at == "imu2" else "imu2.csv"
    assert len({(tmp_path / name / other).read_bytes() for name in asked}) == 1


def test_only_what_the_untouched_recording_does_not_have_counts():
    def said(*findings):
        verdict = "no mismatch" if not findings else "explained"
        return Diagnosis("r", "hinge", verdict, (1.0, 1.0), (), findings, (), FitQuality((1.0, 1.0)), "", 1.0)

    gain = Interval(1.0, (0.0, 2.0))
    play, bias = Finding("joint_play", "joint", 0.9, {}, gain), Finding("accel_bias", "imu1", 0.9, {}, gain)
    new = beside(said(play, bias), said(play))
    assert (new.verdict, [f.effect for f in new.findings]) == ("explained", ["accel_bias"])
    assert beside(said(play), said(play)).verdict == "no mismatch"


def test_of_what_both_recordings_have_the_change_counts():
    def said(*findings):
        return Diagnosis("r", "hinge", "explained", (1.0, 1.0), (), findings, (), FitQuality((1.0, 1.0)), "", 1.0)

    def bias(*value, effect="accel_bias"):
        number = {"bias": Parameter(np.array(value), np.full(3, 0.01), "m/s^2")}
        return Finding(effect, "imu1", 0.9, number, Interval(1.0, (0.0, 2.0)))

    own = bias(0.02, 0.0, -0.1)
    (new,) = beside(said(bias(0.12, 0.01, -0.1)), said(own)).findings
    assert new.parameters["bias"].value == pytest.approx([0.1, 0.01, 0.0])
    assert new.parameters["bias"].std == pytest.approx(np.full(3, 0.01 * np.sqrt(2)))
    assert not beside(said(bias(0.04, 0.01, -0.12)), said(own)).findings
    hums = [bias(*v, effect="vibration") for v in ((0.1, 0.0, 0.0), (0.5, 0.0, 0.0))]
    assert beside(said(hums[1]), said(hums[0])).findings == (hums[1],)  # it is another one, not the sum of two


@pytest.mark.long
def test_a_proof_on_real_recordings_end_to_end(recording, tmp_path):
    (tmp_path / "silent.py").write_text(SILENT)
    settings = Settings(2, 3, f"{tmp_path / 'silent.py'} {{recording}} {{out}}", added=str(recording.parent))
    done = prove(settings, tmp_path / "out", 2, lambda *seen: None, lambda sealed: None)
    assert not any(s.failed for s in done.scores), done.scores
    assert [s.kind for s in done.scores] == ["one", "one"]
    assert not any(s.alarm for s in done.scores)  # what it says, it says of the untouched one too
    assert len(json.loads((Path(tmp_path) / "out" / "commitments.json").read_text())["cases"]) == 3


def test_real_recordings_take_effects(tmp_path, recordings):
    from imubench.convert import CONVERTERS

    source = recordings / "diodem" / "trial1"
    one = CONVERTERS["diodem"](source, segments="3-4", imu="rigid")[0]
    format1.write_recording(one.recording, tmp_path / "rec", one.reference)
    truth = add(tmp_path / "rec", tmp_path / "out", "accel_scale", "imu1", 1, "strong")
    assert truth["rig"] == one.recording.rig
    assert format1.read(tmp_path / "out")[0].imus[0].accel.shape == one.recording.imus[0].accel.shape
