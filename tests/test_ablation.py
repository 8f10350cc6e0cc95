"""What rules are good for, by a folder of recordings: graded, gone on with, and counted."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import pytest

from benchmarks import ablation
from benchmarks.ablation import Tally, compared, credit, recordings, table, tallies, truth_of, work
from imubench.answers import write_json
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.result import UNKNOWN, Finding, Interval, Rejected, Where
from imubench.diagnosis.rules import RULES, Rules
from imubench.format1 import read
from imubench.proof.case import make_case

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


@dataclass(frozen=True)
class Said:
    """What is kept of a diagnosis."""

    findings: tuple
    verdict: str = "explained"
    seconds: float = 1.0


def diagnosed(recording, rules):
    """Stand in for a diagnosis: `drop` changes something when asked the second time, `merge` finds a bias at last."""
    print(recording.name, file=recording.log, flush=True)
    rules.holds("drop", lambda: False)
    rules.holds("drop", lambda: True)
    found = rules.those("merge", lambda: [finding("gyro_bias")])
    return Said(tuple(found)), None


@pytest.fixture
def faked(folder, monkeypatch):
    """Return what was diagnosed, by name, once a recording is a name and its diagnosis the one above."""
    with (folder / "log").open("a") as log:
        monkeypatch.setattr(ablation, "read", lambda path: (SimpleNamespace(name=path.parent.name, log=log), None))
        monkeypatch.setattr(ablation, "diagnose", diagnosed)
        yield lambda: (folder / "log").read_text().split()


def test_from_where_a_rule_first_fired_a_copy_goes_on_without_it_and_nothing_is_done_twice(folder, faked):
    steps = work(folder / "in", folder / "out")
    next(steps)
    steps.close()  # stopped on the way
    assert faked() == ["one"]
    list(work(folder / "in", folder / "out"))
    done = faked()
    assert done == ["one", "one", "two", "two"]  # with all, and once for all copies
    assert list(work(folder / "in", folder / "out")) == [
        "one: gyro_bias at imu1 (0.96)",
        "two: gyro_bias at imu1 (0.96)",
    ]
    assert faked() == done
    assert ablation.kept(folder / "out" / "one" / "all.json")["first"] == {"drop": 2, "merge": 1}
    assert ablation.kept(folder / "out" / "one" / "merge.json")["fired"] == {"drop": 1}
    assert ablation.kept(folder / "out" / "one" / "drop.json")["fired"] == {"merge": 1}


def test_a_rule_may_be_left_alone_and_the_others_are_counted(folder, faked, monkeypatch):
    list(work(folder / "in", folder / "out", but=["drop"]))
    found = {t.rule: t for t in tallies(folder / "out")}
    assert found["merge"] == Tally("merge", 2, 2, 2, better=1, worse=1)  # nothing is true of the second
    assert found["drop"] == Tally("drop", 2)
    list(work(folder / "in", folder / "out"))
    found = {t.rule: t for t in tallies(folder / "out")}
    assert found["drop"].asked == 2
    rows = table(list(found.values())).splitlines()
    assert {row.split()[1] for row in rows[2:4]} == {"drop", "merge"}
    assert "| merge | 2 | 2 of 2 | 1 | 1 |" in rows
    monkeypatch.setenv("IMUBENCH_ABLATION", str(folder / "out"))
    assert {row.what.split()[1].rstrip(":") for row in ablation.run()} == {"drop", "merge"}


def test_a_diagnosis_by_other_code_is_made_again(folder, faked):
    path = folder / "out" / "one" / "all.json"
    path.parent.mkdir()
    write_json(path, {"code": "other"})
    ablation.with_all(folder / "in" / "one", [], path)
    assert ablation.kept(path) is not None
    assert len(RULES) == len(tallies(folder / "out"))


@pytest.mark.long
def test_a_copy_says_what_a_whole_diagnosis_without_the_rule_says(tmp_path):
    folder = tmp_path / "in" / "biased"
    make_case(folder / "recording", "pendulum", [("gyro_bias", "imu1")], 5, "strong", seconds=5.5, rate=40.0)
    write_json(folder / "truth.json", {"effects": [BIAS]})
    list(work(tmp_path / "in", tmp_path / "out", but=RULES.keys() - {"add"}))
    assert ablation.kept(tmp_path / "out" / "biased" / "all.json")["credit"] == pytest.approx(1.0)
    copy = ablation.kept(tmp_path / "out" / "biased" / "add.json")
    whole, evidence = diagnose(read(folder / "recording")[0], rules=Rules(frozenset({"add"})))
    assert copy["said"] == repr(replace(whole, seconds=0.0))
    assert copy["fired"] == dict(evidence.fired) and "add" not in copy["fired"]
