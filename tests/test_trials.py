"""Blind trials end to end on short cases: the seal, the resumption, and cheats planted on purpose."""

import json
import os
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from imubench.errors import InputError
from imubench.proof.mixture import mixture
from imubench.trials import blind
from imubench.trials.make import leaks, made, shortened
from imubench.trials.prove import prove
from imubench.trials.seal import check, check_proof, commitment, salt_of
from imubench.trials.settings import Settings
from imubench.trials.stages import make_cases, publish

SEED = 5
SILENT = """
import json, pathlib, sys
recording, out = sys.argv[1:3]
assert (pathlib.Path(recording) / "recording.toml").read_text().startswith("format")
{cheat}
pathlib.Path(out).mkdir()
answer = {{"format": 1, "recording": "recording", "rig": "hinge", "verdict": "no mismatch",
  "misfit": {{"nominal": 1.0, "explained": 1.0, "unit": ""}}, "where": [], "findings": [], "rejected": [],
  "fit": {{"heldout": {{"before": 1.0, "after": 1.0}},
  "left_out_channel": {{"before": {{}}, "after": {{}}, "unit": ""}},
  "reference": {{"before": {{}}, "after": {{}}, "unit": ""}}}}, "model": "", "seconds": 0.1}}
(pathlib.Path(out) / "diagnosis.json").write_text(json.dumps(answer))
"""


def quiet(stage, done, total):
    """Shows nothing."""


def program(folder: Path, cheat: str = "") -> str:
    """A diagnosis that finds nothing, and what it tries besides; returns its command."""
    file = folder / f"silent{abs(hash(cheat))}.py"
    file.write_text(SILENT.format(cheat=cheat))
    return f"{file} {{recording}} {{out}}"


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """A short case with something to tell."""
    folder = tmp_path_factory.mktemp("case") / "recording"
    question = next(q for q in mixture(SEED, 20) if q.kind == "one" and q.observable)
    return folder, made(shortened(question, 6.0), folder)


@pytest.mark.long
def test_a_proof_is_sealed_diagnosed_opened_and_scored(tmp_path):
    announced = []
    done = prove(Settings(4, SEED, program(tmp_path), seconds=6.0), tmp_path / "out", 2, quiet, announced.append)
    names = {p.name for p in (tmp_path / "out").iterdir()} - {".imubench.json"}
    assert names == {"commitments.json", "truths.json", "proof.json", "report.html", "diagnoses"}
    assert announced == [done.sealed]
    assert check_proof(tmp_path / "out") == 4
    content = json.loads((tmp_path / "out" / "proof.json").read_text())
    assert [c["verdict"] for c in content["cases"]] == ["no mismatch"] * 4
    assert content["settings"]["seed"] == SEED and content["refused"] == {}
    assert "src='data:image/png" in (tmp_path / "out" / "report.html").read_text()
    assert not list(tmp_path.glob(".out*"))


def test_a_truth_changed_after_the_seal_is_found(case, tmp_path):
    _, truth = case
    salt = salt_of(SEED, "000")
    sealed = {"000": {"truth": commitment(truth, salt)}}
    check(sealed, {"000": truth}, {"000": salt})
    with pytest.raises(InputError, match="seal of case 000: expected the truth that was sealed"):
        check(sealed, {"000": truth | {"kind": "none"}}, {"000": salt})
    with pytest.raises(InputError, match="seal: expected a truth for every commitment"):
        check(sealed, {}, {})
    with pytest.raises(InputError, match=r"commitments\.json: expected a file, got nothing"):
        check_proof(tmp_path)


@pytest.mark.long
def test_an_interrupted_proof_goes_on_where_it_was(tmp_path):
    calls = []

    def stop(stage, done, total):
        calls.append((stage, done))
        if stage == "diagnose" and done == 2 and len([c for c in calls if c == ("diagnose", 2)]) == 1:
            raise KeyboardInterrupt

    settings = Settings(3, SEED, program(tmp_path), seconds=6.0)
    with pytest.raises(KeyboardInterrupt):
        prove(settings, tmp_path / "out", 1, stop, lambda sealed: None)
    assert not (tmp_path / "out").exists()
    kept = list(tmp_path.glob(".out.trials/*/answers/*/run.json"))
    assert 2 <= len(kept) < 4
    assert not list(tmp_path.glob(".out.trials/**/truth*"))  # no file holds a truth meanwhile
    before = {p: p.stat().st_mtime_ns for p in kept}
    beside = replace(settings, leave_one_out=True)  # asked for only now; what is answered stays answered
    prove(beside, tmp_path / "out", 1, lambda *seen: calls.append(seen[:2]), lambda sealed: None)
    assert ("diagnose", len(before)) in calls[-6:]
    assert check_proof(tmp_path / "out") == 3


def test_other_truths_than_the_sealed_ones_are_refused_on_going_on(case, tmp_path):
    _, truth = case
    (tmp_path / "cases" / "000" / "recording").mkdir(parents=True)
    first = publish({"000": truth}, tmp_path, SEED)
    assert publish({"000": truth}, tmp_path, SEED) == first  # as a run that goes on finds it
    with pytest.raises(InputError, match="expected the cases that an earlier run sealed"):
        publish({"000": truth | {"kind": "none"}}, tmp_path, SEED)


def test_a_recording_tells_nothing_of_its_truth(case):
    assert leaks(*case) == []


@pytest.mark.long
def test_a_truth_planted_into_a_file_name_or_a_header_is_caught(tmp_path):
    question = shortened(next(q for q in mixture(SEED, 20) if q.kind == "one" and q.observable), 6.0)
    name = question.effects[0][0]
    told = replace(question, options=question.options | {"name": name})
    with pytest.raises(InputError, match=f"does not tell its truth, got word '{name}' in recording.toml"):
        make_cases({"000": told}, tmp_path / "cases", 1, quiet)
    truth = made(question, tmp_path / "recording")
    (tmp_path / "recording" / f"{name}.txt").write_text("")
    assert leaks(tmp_path / "recording", truth) == [f"file '{name}.txt'"]
    (tmp_path / "recording" / f"{name}.txt").unlink()
    (tmp_path / "recording").rename(tmp_path / name)
    assert leaks(tmp_path / name, truth) == [f"folder '{name}'"]


CHEATS = {
    "reads the seal": ("open({secret!r}).read()", "read "),
    "looks around": ("import os; os.listdir({folder!r})", "list "),
    "makes the case again": ("import imubench.proof.mixture", "import imubench.proof"),
    "asks the trials": ("import imubench.trials.seal", "import imubench.trials"),
    "sends another to look": ("import subprocess; subprocess.run(['cat', {secret!r}])", "start "),
    "leaves a note": ("open({note!r}, 'w').write('x')", "write "),
}


@pytest.mark.parametrize("cheat", list(CHEATS))
def test_a_diagnosis_that_wants_more_than_its_recording_is_caught(cheat, case, tmp_path):
    hidden = tmp_path / "hidden"
    hidden.mkdir()
    (hidden / "truths.json").write_text("{}")
    lines, what = CHEATS[cheat]
    places = {"secret": str(hidden / "truths.json"), "folder": str(hidden), "note": str(hidden / "note")}
    tried = f"try:\n    {lines.format(**places)}\nexcept PermissionError:\n    pass"  # it hides that it was refused
    run = blind.diagnosed(case[0], tmp_path / "kept", program(tmp_path, tried), 60.0, blind.Children())
    assert run.code == 0 and run.refused[0].startswith(what), run
    assert not (hidden / "note").exists()


@pytest.mark.long
def test_a_cheat_has_no_score_and_fails_the_proof(tmp_path):
    (tmp_path / "truths.json").write_text("{}")
    peek = f"try:\n    open({str(tmp_path / 'truths.json')!r})\nexcept OSError:\n    pass"
    done = prove(Settings(1, SEED, program(tmp_path, peek), seconds=6.0), tmp_path / "out", 1, quiet, lambda s: None)
    assert not done.fit_for_the_build and list(done.refused) == ["000"]
    assert done.scores[0].failed.startswith("tried to see more than its recording: read ")
    assert "cheat" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_the_command_line_with_the_seed_is_out_of_reach(case, tmp_path):
    look = f"try:\n    open('/proc/{os.getpid()}/cmdline').read()\n    found = True\nexcept OSError:\n    found = False"
    look += "\nassert not found"
    run = blind.diagnosed(case[0], tmp_path / "kept", program(tmp_path, look), 60.0, blind.Children())
    assert run.code == 0, run


def test_the_environment_of_a_diagnosis_has_nothing_of_ours(tmp_path, monkeypatch):
    monkeypatch.setenv("IMUBENCH_SEED", "5")
    env = blind.environment(tmp_path)
    assert "IMUBENCH_SEED" not in env and env["HOME"] == str(tmp_path)


def test_a_diagnosis_that_hangs_is_stopped_and_said_to_have_failed(case, tmp_path):
    command = program(tmp_path, "import time; time.sleep(60)")
    run = blind.diagnosed(case[0], tmp_path / "kept", command, 1.0, blind.Children())
    assert (run.code, run.error) == (-1, "stopped after 1 s")


def test_a_diagnosis_needs_to_be_told_where(tmp_path):
    with pytest.raises(InputError, match=r"expected the words \{recording\} and \{out\}"):
        blind.words("imubench diagnose", tmp_path)
