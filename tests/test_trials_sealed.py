"""Recordings with sealed sidecars: the seal, what is accepted, and a proof on them end to end."""

import json
from pathlib import Path

import pytest

from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Interval
from imubench.errors import InputError
from imubench.proof.case import make_case
from imubench.trials.prove import prove
from imubench.trials.scoring import score
from imubench.trials.seal import check_proof
from imubench.trials.sealed import as_scored, checked, commitments, opened, seal, without_known
from imubench.trials.settings import Settings

ROCKS = [{"effect": "rocking_mount", "at": "imu2"}, {"effect": "soft_mount", "at": "imu2"}]
BIASED = {"effect": "accel_bias", "at": "imu1"}
FOAM = {"documented": "foam under the second IMU", "effects": [ROCKS], "may": [BIASED]}
RIGID = {"documented": "screwed on", "effects": [], "may": [BIASED]}
SAYS = """
import json, pathlib, sys
recording, out = map(pathlib.Path, sys.argv[1:3])
text = (recording / "recording.toml").read_text()
assert 'name = "recording"' in text and not (recording / "notes.txt").exists()
gain = {"value": 1.0, "ci": [0.0, 2.0], "unit": "nat"}
findings = [{"effect": e, "at": at, "confidence": 0.95, "parameters": {}, "equivalent": [], "separate_by": "",
  "heldout_gain": gain} for e, at in (("soft_mount", "imu2"), ("accel_bias", "imu1"))]
pair = {"before": {}, "after": {}, "unit": ""}
out.mkdir()
(out / "diagnosis.json").write_text(json.dumps({"format": 1, "recording": "recording", "rig": "hinge",
  "verdict": "explained", "misfit": {"nominal": 4.0, "explained": 1.0, "unit": ""}, "where": [], "findings": findings,
  "rejected": [], "fit": {"heldout": {"before": 1.0, "after": 1.0}, "left_out_channel": pair, "reference": pair},
  "model": "", "seconds": 0.1}))
"""


@pytest.fixture
def folder(tmp_path):
    """Two sealed recordings by the independent generator, one on foam."""
    out = tmp_path / "lab"
    out.mkdir()
    for name, effects, truth in (
        ("monday", [("rocking_mount", "imu2")], FOAM),
        ("tuesday", [], RIGID),
    ):
        make_case(out / name, "hinge", effects, 4, "strong", seconds=12.0, rate=50.0, name=f"{name}-foam")
        (out / name / "notes.txt").write_text("foam")
        (out / f"{name}.truth.json").write_text(json.dumps(truth))
        seal(out / f"{name}.truth.json")
    return out


def said(*findings):
    gain = Interval(1.0, (0.0, 2.0))
    found = tuple(Finding(e, at, 0.95, {}, gain) for e, at in findings)
    verdict = "explained" if found else "no mismatch"
    return Diagnosis("r", "hinge", verdict, (4.0, 1.0), (), found, (), FitQuality((4.0, 1.0)), "", 1.0)


def settings(folder: Path, tmp_path: Path) -> Settings:
    (tmp_path / "says.py").write_text(SAYS)
    return Settings(1, 0, f"{tmp_path / 'says.py'} {{recording}} {{out}}", seconds=8.0, real=str(folder))


def quiet(*seen):
    """Shows nothing."""


def test_the_public_part_of_a_seal_tells_nothing(folder):
    public = json.loads((folder / "monday.commitment.json").read_text())
    assert set(public) == {"format", "truth", "recording"} and len(public["truth"]) == 64
    sealed = json.loads((folder / "monday.sealed.json").read_text())
    assert len(sealed["salt"]) == 64  # 32 random bytes: nobody guesses a truth from its hash
    assert sealed["truth"] == FOAM | {"recording": public["recording"]}
    first = public["truth"]
    assert seal(folder / "monday.truth.json") != first  # a new salt each time


@pytest.mark.long
def test_a_proof_on_sealed_recordings_end_to_end(folder, tmp_path):
    done = prove(settings(folder, tmp_path), tmp_path / "out", 2, quiet, lambda sealed: None)
    monday, tuesday = done.scores
    assert (monday.kind, monday.first_right, monday.named, monday.wrong) == ("one", True, 1, ())
    assert monday.truth == ["rocking_mount at imu2 or soft_mount at imu2"]
    assert monday.found == ("soft_mount at imu2 (0.95)",)  # the bias, which may be there, counts neither way
    assert (tuesday.kind, tuesday.alarm, tuesday.wrong) == ("none", True, ("soft_mount at imu2",))
    figure = {f.name: (f.value, f.n) for f in done.figures}
    assert figure["real_silent"] == (1.0, 1) and figure["real_named"] == (1.0, 1)
    assert figure["real_located"] == (1.0, 1)
    assert figure["false_alarms_white"] == (None, 0)
    assert check_proof(tmp_path / "out") == 2


@pytest.mark.long
def test_the_truth_may_come_after_the_diagnoses(folder, tmp_path):
    kept_back = folder / "monday.sealed.json"
    content = kept_back.read_bytes()
    kept_back.unlink()
    asked, stages = settings(folder, tmp_path), []
    with pytest.raises(InputError, match=r"monday\.sealed\.json: expected the sealed truth to open, got none"):
        prove(asked, tmp_path / "out", 1, quiet, lambda sealed: None)
    assert not (tmp_path / "out").exists()
    kept_back.write_bytes(content)
    prove(asked, tmp_path / "out", 1, lambda *seen: stages.append(seen), lambda sealed: None)
    assert [stage for stage in stages if stage[0] == "diagnose"] == [("diagnose", 2, 2)]  # none of them again


def test_what_was_changed_after_the_seal_is_found(folder, tmp_path):
    file = folder / "tuesday.sealed.json"
    content = json.loads(file.read_text())
    content["truth"]["effects"] = [[{"effect": "soft_mount", "at": "imu2"}]]
    file.write_text(json.dumps(content))
    with pytest.raises(InputError, match="seal of case tuesday: expected the truth that was sealed"):
        prove(settings(folder, tmp_path), tmp_path / "out", 2, quiet, lambda sealed: None)
    table = folder / "monday" / "imu1.csv"
    table.write_text(table.read_text() + "\n")
    with pytest.raises(InputError, match="expected the recording that was sealed, got one with another hash"):
        commitments(folder)
    with pytest.raises(InputError, match="expected the recording that was sealed"):
        opened(folder, ["monday"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"effects": [[{"effect": "wobble", "at": "imu1"}]]}, "unknown effect 'wobble'"),
        ({"effects": [[{"effect": "soft_mount", "at": "imu3"}]]}, "expected imu1, imu2, joint, body or world"),
        ({"effects": [BIASED]}, "expected a list of lists of accepted answers"),
        ({"effects": [[{"effect": "soft_mount"}]]}, "expected an answer with the keys effect and at"),
        ({"more": 1}, "expected the keys documented, effects, may"),
    ],
)
def test_a_truth_that_cannot_be_scored_is_not_sealed(change, message):
    with pytest.raises(InputError, match=message):
        checked(FOAM | change, "x.truth.json")


def test_a_folder_without_sealed_recordings_is_refused(tmp_path):
    with pytest.raises(InputError, match="expected folders in format 1 with sealed sidecars, got none"):
        commitments(tmp_path)
    with pytest.raises(InputError, match=r"expected a file NAME\.truth\.json"):
        seal(tmp_path / "truth.json")


def test_physics_outside_the_table_is_documented_as_unknown(folder):
    truth = RIGID | {"effects": [[{"effect": "unknown", "at": "imu1"}]]}
    scored = as_scored(truth, folder / "monday")
    assert scored["kind"] == "outside"
    s = score("monday", scored, without_known(said(("accel_bias", "imu1")), scored), 1.0, 1.6)
    assert (s.flagged, s.verdict, s.alarm) == (False, "no mismatch", False)


@pytest.mark.long
def test_the_four_real_recordings_are_sealed_and_do_not_tell(tmp_path, recordings):
    from benchmarks.sealed_diodem import sealed_folder

    hashes = sealed_folder(recordings / "diodem" / "trial1", tmp_path / "lab", 20.0)
    assert len(set(hashes)) == 4
    headers = [p.read_text() for p in sorted((tmp_path / "lab").glob("*/recording.toml"))]
    assert len({h.replace(f"case{k}", "case") for k, h in enumerate(headers, 1)}) == 2  # one for each joint
    done = prove(settings(tmp_path / "lab", tmp_path), tmp_path / "out", 2, quiet, lambda sealed: None)
    assert [s.kind for s in done.scores] == ["none", "several", "none", "several"]
    assert [s.named for s in done.scores] == [0, 1, 0, 1]  # the planted answer names one of two mounts


def test_every_option_of_the_command_reaches_the_trials(tmp_path, monkeypatch):
    from typer.testing import CliRunner

    from imubench import cli
    from imubench.commands.work import prove

    seen = []
    monkeypatch.setattr(prove, "run", lambda settings, *rest: seen.append(settings) or 0)
    options = ["--crime", "--leave-one-out", "--baselines", "--real", str(tmp_path), "--seconds", "9", "--cases", "3"]
    assert CliRunner().invoke(cli.app, ["prove", *options]).exit_code == 0
    (s,) = seen
    assert (s.crime, s.leave_one_out, s.baselines, s.real, s.seconds) == (True, True, True, str(tmp_path), 9.0)
    assert s.seed == 0  # nothing is drawn for recordings that are there, so the same command goes on
