"""`imubench check`: the same verdict from the same runs, whoever makes them and however often it was stopped."""

import json
import math
import shutil
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from imubench.checks import runs as runs_module
from imubench.checks.baseline import read_baselines
from imubench.checks.check import check
from imubench.checks.outputs import claims_content, junit, summary
from imubench.checks.runs import Subject, running
from imubench.errors import InputError
from tests.claimed import AXIS, MadeUp, loaded, written
from tests.command import here, imubench

SOON = AXIS + 'over = "median"\nconfidence = 0.9\npower = 0.9\nbaseline_power = 0.9\n'
"""The claim, decided in a few runs."""
DEGREE = math.radians(1.0)
GOOD, BAD = [DEGREE, 0.5 * DEGREE], [4 * DEGREE, 5 * DEGREE]
TWO = AXIS + '[claim.often]\nfigure = "best_pairing_rmsae"\nat_most = "2 deg"\nat_least = 0.9\n'


def test_runs_stop_as_soon_as_all_is_decided(tmp_path):
    made_up = MadeUp(GOOD)
    axis, often = check(loaded(tmp_path, TWO), made_up)
    assert axis.holds and often.holds
    assert made_up.made == max(axis.bound.runs, often.bound.runs) == len(axis.errors)  # the claims share their runs
    assert axis.bound.runs != often.bound.runs
    alone = check(loaded(tmp_path), MadeUp(GOOD))[0]
    assert alone.bound.runs == axis.bound.runs  # whatever else needs more
    assert not check(loaded(tmp_path), MadeUp(BAD))[0].holds


def test_a_claim_that_is_neither_true_nor_broken_stays_undecided(tmp_path):
    (one,) = check(loaded(tmp_path, AXIS + "max_runs = 20\n"), MadeUp([2.2 * DEGREE]))
    assert one.bound.verdict == "undecided"
    assert one.bound.why_undecided == "max_runs = 20 do not decide it"
    (entry,) = claims_content([one], "claims.toml")
    assert (entry["verdict"], entry["decided"], entry["runs"]) == ("fails", False, 20)


def test_an_estimate_that_is_missing_fails_a_mean_and_counts_in_a_share(tmp_path):
    axis, often = check(loaded(tmp_path, TWO), MadeUp([*GOOD * 20, None]))
    assert axis.bound.verdict == "fails"
    assert axis.bound.missing == [(40, "crashed: no")]
    assert often.bound.verdict == "holds"  # 40 of 41 are good
    assert claims_content([axis], "c")[0]["measured"] is None


def test_a_figure_that_the_answers_never_have_is_bad_input(tmp_path):
    (tmp_path / "mine.py").write_text("def estimate(recording):\n    return None\n")
    text = AXIS.replace("best_pairing_rmsae", "error_imu1").replace("deg", "mm")
    claims = loaded(tmp_path, text + 'estimator = "mine.py:estimate"\n')
    with pytest.raises(InputError, match=r"figure of mine\.py:estimate 'error_imu1'; known: best_pairing_rmsae"):
        check(claims, MadeUp(GOOD))


def test_paired_axes_are_missing_where_the_pairing_is_unknown(tmp_path):
    (one,) = check(loaded(tmp_path, AXIS.replace("best_pairing_", "")), MadeUp(GOOD))
    assert one.bound.verdict == "fails"
    assert one.bound.missing[0][1] == "the sign pairing is unknown, which leaves best_pairing_rmsae"


def baseline_of(folder: Path, errors: list[float], least: int = 60):
    claims = loaded(folder)
    done = check(claims, MadeUp(errors), least=least)
    (folder / "baseline.json").write_text(json.dumps(claims_content(done, "claims.toml")))
    return claims, read_baselines(folder / "baseline.json", claims)


def test_a_candidate_is_compared_with_a_baseline_on_the_same_runs(tmp_path):
    claims, baselines = baseline_of(tmp_path, GOOD)
    (same,) = check(claims, MadeUp(GOOD), baselines=baselines)
    assert same.holds
    assert same.baseline.runs <= 20  # unchanged on every run; a power of 0.9999 asks for log(10,000) in bets of 0.6
    (worse,) = check(claims, MadeUp([1.2 * e for e in GOOD]), baselines=baselines)
    assert worse.bound.verdict == "holds"  # well within two degrees
    assert worse.baseline.verdict == "fails"
    assert worse.baseline.measured == pytest.approx(1.2)
    entries = claims_content([worse], "claims.toml")
    assert [e["name"] for e in entries] == ["axis", "axis beside the baseline"]
    assert [e["verdict"] for e in entries] == ["holds", "fails"]


def test_a_baseline_that_is_too_short_or_of_something_else(tmp_path):
    claims, baselines = baseline_of(tmp_path, GOOD)
    last = max(baselines["axis"].errors)
    (one,) = check(claims, MadeUp(GOOD), first=last - 2, baselines=baselines)
    assert (one.baseline.verdict, one.baseline.runs) == ("undecided", 3)
    file = tmp_path / "baseline.json"
    whole = json.loads(file.read_text())
    for key, value, told in (
        ("figure", "maxae", "expected the figure of the claim"),
        ("scenario", "name hinge-hand", "expected the scenario of the claim"),
        ("first_run", -1, "first_run: expected a whole number"),
        ("errors", [-1.0], "errors: expected numbers from 0 on, or null"),
    ):
        file.write_text(json.dumps([{**whole[0], key: value}]))
        with pytest.raises(InputError, match=told):
            read_baselines(file, claims)
    file.write_text("[]")
    with pytest.raises(InputError, match="with the errors of each run, got none"):
        read_baselines(file, claims)


class Stop(BaseException):
    """As if Ctrl-C had come."""


def test_a_check_that_was_stopped_goes_on_with_the_runs_it_had(tmp_path, monkeypatch):
    claims, out, played, numbers = loaded(tmp_path, SOON), tmp_path / "out", runs_module.played, []

    def counted(subject: Subject, number: int):
        if len(numbers) == 5:
            numbers.append(None)
            raise Stop
        numbers.append(number)
        return played(subject, number)

    monkeypatch.setattr(runs_module, "played", counted)
    with pytest.raises(Stop), running(1, out) as runs:
        check(claims, runs, least=8)
    assert [p.name for p in tmp_path.iterdir() if p.is_dir()] == [".out.runs"]
    with running(1, out) as runs:
        gone_on = check(claims, runs, least=8)
    assert numbers[:7] == [0, 1, 2, 3, 4, None, 5]  # none is run twice
    assert not (tmp_path / ".out.runs").exists()
    with running(1, None) as runs:
        at_once = check(claims, runs, least=8)
    assert claims_content(gone_on, "c") == claims_content(at_once, "c")


def test_runs_that_were_damaged_are_run_again(tmp_path):
    path = tmp_path / "runs.json"
    for content in ('{"0": 1}', "half a file", '{"x": {"figures": {}, "why": ""}}', '{"0": {"figures": {"a": "b"}}}'):
        path.write_text(content)
        assert runs_module.stored_runs(path) == {}


@pytest.mark.long
def test_two_processes_come_to_what_one_does(tmp_path):
    path = written(tmp_path, TWO)
    for workers in ("1", "2"):
        done = imubench("check", path, "--workers", workers, "--out", workers, folder=tmp_path, limit=300)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "1" / "claims.json").read_bytes() == (tmp_path / "2" / "claims.json").read_bytes()
    assert done.stdout.startswith("all 2 claims hold\n")


def test_the_command_writes_what_it_says(tmp_path, monkeypatch):
    exact = AXIS.replace("axis", "exact").replace("2 deg", "0.001 deg")
    claims = SOON + exact
    path, shown = written(tmp_path, claims), tmp_path / "shown.md"
    shown.write_text("before\n")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(shown))
    monkeypatch.chdir(tmp_path)
    done = here("check", path.name, "--workers", "1", "--out", "out", "--save-baseline", "base.json", "--runs", "8")
    assert done.code == 1, done.err
    assert done.out.startswith("1 of 2 claims fails: exact\nfails     exact: ")
    assert "a true claim fails with a probability of at most 1 %" in done.out
    entries = json.loads((tmp_path / "out" / "claims.json").read_text())
    assert [e["verdict"] for e in entries] == ["holds", "fails"]
    assert json.loads((tmp_path / "base.json").read_text()) == entries
    assert len(entries[0]["errors"]) >= 8
    text = (tmp_path / "out" / "summary.md").read_text()
    assert shown.read_text() == "before\n" + text
    assert text.startswith("## imubench check: 1 of 2 claims fails: exact\n")
    again = here("check", path.name, "--workers", "1", "--only", "axis", "--against", "base.json", "--out", "out")
    assert again.code == 0, again.err
    assert "axis beside the baseline: best\\_pairing" not in again.out
    assert "holds     axis beside the baseline: best_pairing_rmsae of seel2012 on quick: not 20 % worse" in again.out
    for words in (("--only", "axes"), ("--against", "claims.toml"), ("--estimator", "nobody")):
        assert here("check", path.name, *words, "--out", "new").code == 2
    assert not (tmp_path / "new").exists()


def test_junit_is_what_pytest_writes(tmp_path, pytester_xml):
    """Build servers read pytest's files: ours has no element and no attribute that those do not have."""
    ours = ElementTree.fromstring(junit(check(loaded(tmp_path, TWO), MadeUp(BAD)), "claims.toml"))
    known = {e.tag: set(e.attrib) for e in pytester_xml.iter()}
    for element in ours.iter():
        assert set(element.attrib) <= known[element.tag], element.tag
    (suite,) = ours
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("2", "2", "0")
    assert [case.get("name") for case in suite] == ["axis", "often"]
    assert "fails: best_pairing_rmsae of seel2012 on quick: rms <= 2 deg" in suite[0].find("failure").text


@pytest.fixture(scope="module")
def pytester_xml(tmp_path_factory):
    """What pytest writes about a test that fails and prints."""
    import subprocess
    import sys

    folder = tmp_path_factory.mktemp("pytest")
    (folder / "test_it.py").write_text("def test_it():\n    print('x')\n    assert False\n")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--junitxml", "it.xml"]
    subprocess.run([*command, "-o", "junit_logging=all"], cwd=folder, capture_output=True, timeout=120, check=False)
    root = ElementTree.parse(folder / "it.xml").getroot()
    shutil.rmtree(folder)
    return root


def test_the_summary_names_what_fails_first_and_holds_no_markup_of_others(tmp_path):
    text = summary(check(loaded(tmp_path, TWO.replace("often", '"a|b<i>*"')), MadeUp(BAD)), "claims.toml")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert rows[1].startswith("| **fails** | axis |")
    assert "a&#124;b&lt;i&gt;\\*" in text
    assert all(row.count(" | ") == 3 for row in rows)
