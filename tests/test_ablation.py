"""What rules are good for, by a folder of recordings: graded, gone on with, and counted."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from benchmarks import ablation
from benchmarks.ablation import Tally, compared, credit, recordings, table, tallies, truth_of, work
from imubench.answers import write_json
from imubench.diagnosis.result import UNKNOWN, Finding, Interval, Rejected, Where
from imubench.diagnosis.rules import RULES

NOTHING = Interval(0.0, (0.0, 0.0))
BIAS = {"effect": "gyro_bias", "at": "imu1"}


def finding(effect, at="imu1", sure=0.96, equal=()):
    where = Where(at, {}, (), (), "nothing clear", 1.0) if effect == UNKNOWN else None
    found = Finding(effect, at, sure, {}, NOTHING, where=where)
    return replace(found, equivalent=tuple(Rejected(name, at, 0.0) for name in equal))


@pytest.mark.parametrize(
    ("said", "true", "worth"),
    [
        ([finding("gyro_bias")], [BIAS], 1.0),
        ([finding("gyro_bias", sure=0.3)], [BIAS], 0.0),  # not said
        ([finding("gyro_bias", "imu2")], [BIAS], -0.96),
        ([finding("gyro_drift", equal=("gyro_bias",))], [BIAS], 0.5),
        ([finding("gyro_bias"), finding("gyro_scale", sure=0.6)], [BIAS], 0.4),
        ([], [], 0.0),
        ([finding(UNKNOWN)], [], -0.96),
        ([finding(UNKNOWN)], [{"effect": "dead_band", "at": "imu1", "inside": False}], 1.0),
    ],
)
def test_findings_are_worth_what_is_right_less_what_is_not(said, true, worth):
    assert credit(said, true) == pytest.approx(worth)


def kept(said="a", worth=1.0, fired=()):
    return {"said": said, "credit": worth, "fired": dict.fromkeys(fired, 1)}


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (None, Tally("merge", fired=1)),  # not asked yet
        (kept(), Tally("merge", 1, 1)),
        (kept("b", 0.0), Tally("merge", 1, 1, 1, better=1)),
        (kept("b", 1.5), Tally("merge", 1, 1, 1, worse=1)),
        (kept("b", 1.01), Tally("merge", 1, 1, 1)),
    ],
)
def test_a_rule_is_counted_by_what_is_said_without_it(other, expected):
    assert compared(Tally("merge"), kept(), other) == expected


@pytest.fixture
def folder(tmp_path):
    """Two recordings with their truths, as the generator and as a run keep them."""
    for name in ("one", "two"):
        (tmp_path / "in" / name / "recording").mkdir(parents=True)
        (tmp_path / "in" / name / "recording" / "recording.toml").write_text("")
    write_json(tmp_path / "in" / "one" / "truth.json", {"effects": [BIAS]})
    write_json(tmp_path / "in" / "two" / "score.json", {"changes": {}})
    (tmp_path / "in" / "none").mkdir()
    (tmp_path / "out").mkdir()
    return tmp_path


def test_recordings_and_what_is_true_of_them(folder):
    assert [name for name, _ in recordings(folder / "in")] == ["one", "two"]
    assert truth_of(folder / "in" / "one") == [BIAS]
    assert truth_of(folder / "in" / "two") == []
    assert truth_of(folder / "in" / "none") is None


def test_only_rules_that_fired_are_asked_and_nothing_is_done_twice(folder, monkeypatch):
    asked = []

    def once(recording, truth, out, rules):
        if (done := ablation.kept(out)) is None:
            asked.append((recording.parent.name, *rules.off))
            found = [finding("gyro_bias")] if "merge" not in rules.off else []
            done = {"code": ablation.code_key(ablation.CODE), "findings": [f.effect for f in found], "verdict": "said"}
            done |= {"said": repr(found), "credit": credit(found, truth), "fired": {"merge": 1, "drop": 2}}
            out.parent.mkdir(exist_ok=True)
            write_json(out, done)
        return done

    monkeypatch.setattr(ablation, "once", once)
    steps = work(folder / "in", folder / "out")
    next(steps)
    next(steps)
    steps.close()  # stopped on the way
    assert asked == [("one",), ("one", "drop")]
    list(work(folder / "in", folder / "out"))
    expected = [("one",), ("one", "drop"), ("one", "merge"), ("two",), ("two", "drop"), ("two", "merge")]
    assert asked == expected
    found = {t.rule: t for t in tallies(folder / "out")}
    assert found["merge"] == Tally("merge", 2, 2, 2, better=1, worse=1)  # nothing is true of the second
    assert found["drop"] == Tally("drop", 2, 2)
    rows = table(list(found.values())).splitlines()
    assert set(rows[2:4]) == {"| drop | 2 | 0 of 2 | 0 | 0 |", "| merge | 2 | 2 of 2 | 1 | 1 |"}
    monkeypatch.setenv("IMUBENCH_ABLATION", str(folder / "out"))
    assert {row.what.split()[1].rstrip(":") for row in ablation.run()} == {"drop", "merge"}


def test_a_diagnosis_by_other_code_is_made_again(folder, monkeypatch):
    path = folder / "out" / "one" / "all.json"
    path.parent.mkdir()
    write_json(path, {"code": "other"})
    said = SimpleNamespace(fired={})
    monkeypatch.setattr(ablation, "read", lambda path: (None, None))
    monkeypatch.setattr(ablation, "diagnose", lambda recording, rules: (None, said))
    monkeypatch.setattr(
        ablation, "as_kept", lambda d, fired, truth: {"code": ablation.code_key(ablation.CODE), "fired": {}}
    )
    ablation.once(folder / "in" / "one", [], path, ablation.Rules())
    assert ablation.kept(path) is not None
    assert len(RULES) == len(tallies(folder / "out"))
