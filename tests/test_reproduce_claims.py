"""Claims and their verdicts."""

import json
import math
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from imubench.commands.work import reproduce as command
from imubench.errors import InputError
from imubench.reproduce import PAPERS
from imubench.reproduce.claims import Claim, Measured, judge, load_claims
from imubench.reproduce.reproduce import Reproduced
from imubench.terminal import Terminal
from tests.papers import BOUNDED, SEEN


@pytest.mark.parametrize(
    ("claim", "value", "verdict"),
    [
        (BOUNDED, 0.01, "holds"),
        (BOUNDED, 2.16, "holds"),
        (BOUNDED, 2.17, "fails"),
        (BOUNDED, math.nan, "fails"),
        (replace(BOUNDED, promise=False), 2.17, "differs"),
        (replace(BOUNDED, kind="at least", limit=100.0), 100.0, "holds"),
        (replace(BOUNDED, kind="at least", limit=100.0), 99.0, "fails"),
        (SEEN, 105.0, "holds"),
        (SEEN, 75.0, "holds"),
        (SEEN, 74.0, "differs"),
        (SEEN, math.inf, "differs"),
    ],
)
def test_a_promise_fails_and_a_figure_differs(claim, value, verdict):
    assert judge(claim, Measured(value, "because")).verdict == verdict


def test_a_bound_reads_as_one():
    assert BOUNDED.bound == "<= 2.16 deg"
    assert SEEN.bound == "90 +- 15 deg"
    entry = judge(BOUNDED, Measured(math.nan, "none was accepted")).as_dict()
    assert entry["measured"] is None  # JSON has no NaN
    assert entry["why"] == "none was accepted"
    assert {"claim", "source", "published", "measured", "unit", "bound", "verdict", "why"} <= entry.keys()


def test_a_guard_that_is_broken_is_called_so_and_ends_the_command_with_1(tmp_path, monkeypatch, capsys):
    held, broken = (judge(replace(BOUNDED, guard=0.5), Measured(x, "because")) for x in (0.4, 0.6))
    failing = judge(BOUNDED, Measured(3.0, "because"))
    for judged, code, said in (([held], 0, ""), ([broken], 1, "guard broken: "), ([failing], 1, "new: ")):
        monkeypatch.setattr(command, "reproduce", lambda *a, judged=judged, **_: Reproduced(judged))
        assert command.run("olsson2020", tmp_path, True, 0, Terminal(), Terminal(stderr=True)) == code
        assert capsys.readouterr().err.startswith(said)


def test_news_is_an_unknown_failure_or_a_guard_that_was_passed():
    failing, guarded = Measured(3.0, "because"), replace(BOUNDED, guard=0.5)
    assert judge(BOUNDED, failing).news == "3 deg instead of <= 2.16 deg"
    assert judge(replace(BOUNDED, known="a reason"), failing).news == ""
    assert judge(replace(SEEN, guard=100.0), Measured(70.0, "because")).news == ""  # differs, and is no worse
    assert judge(guarded, Measured(0.5, "because")).news == ""
    assert judge(guarded, Measured(0.6, "because")).verdict == "holds"
    assert judge(guarded, Measured(0.6, "because")).news == "0.6 deg is beyond the guard of 0.5"
    assert judge(replace(guarded, known="a reason"), Measured(math.nan, "because")).worse
    least = replace(BOUNDED, kind="at least", limit=1.0, guard=2.0)
    assert judge(least, Measured(1.5, "because")).worse
    assert not judge(least, Measured(2.5, "because")).worse


def test_the_build_stops_for_news_only(tmp_path):
    command = [sys.executable, str(Path(__file__).resolve().parent.parent / "scripts" / "new_failures.py")]
    files = []
    for name, claim in (("old", replace(BOUNDED, known="a reason")), ("new", BOUNDED)):
        files.append(tmp_path / f"{name}.json")
        files[-1].write_text(json.dumps([judge(claim, Measured(3.0, "because")).as_dict()]))
    fine = subprocess.run([*command, files[0]], capture_output=True, text=True)
    assert (fine.returncode, fine.stdout) == (0, "claims: nothing new\n")
    stopped = subprocess.run([*command, *files], capture_output=True, text=True)
    assert (stopped.returncode, stopped.stdout) == (1, f"{files[1]}: c: 3 deg instead of <= 2.16 deg\n")


GOOD = """[one]
claim = "Errors are small"
source = "section 1"
published = 2
unit = "deg"
kind = "at most"
limit = 2.5
basis = "stated"
measure = "worst"
promise = true
"""


def claims(tmp_path: Path, text: str) -> tuple[Claim, ...]:
    file = tmp_path / "claims.toml"
    file.write_text(text)
    return load_claims(file, {"worst": None})


def test_claims_are_read(tmp_path):
    (claim,) = claims(tmp_path, GOOD)
    assert claim == Claim("one", "Errors are small", "section 1", 2.0, "deg", "at most", 2.5, "stated", "worst", True)
    assert not claims(tmp_path, GOOD.replace("promise = true\n", ""))[0].promise
    (claim,) = claims(tmp_path, GOOD + 'guard = 1\nknown = "a reason"\n')
    assert (claim.guard, claim.known) == (1.0, "a reason")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('unit = "deg"\n', "", "claims.toml: one: expected the key 'unit'"),
        ("limit = 2.5", 'limit = "2.5"', "claims.toml: one.limit: expected a finite number, got '2.5'"),
        ("limit = 2.5", "limit = nan", "claims.toml, key 'one.limit': expected a finite number, got nan"),
        ("limit = 2.5", "limit = true", "claims.toml: one.limit: expected a finite number, got True"),
        ("promise = true", "promise = 1", "claims.toml: one.promise: expected true or false, got 1"),
        ('basis = "stated"', 'basis = ""', "claims.toml: one.basis: expected a text"),
        ('kind = "at most"', 'kind = "below"', "unknown kind in claims.toml: one 'below'; known: at most"),
        ('kind = "at most"', 'kind = "about"', "expected a promise with a bound on one side"),
        ('measure = "worst"', 'measure = "best"', "unknown measure in claims.toml: one 'best'; known: worst"),
        ("promise = true", 'known = "a reason"', "claims.toml: one.known: expected a promise, which can fail"),
        ("promise = true", "guard = true", "claims.toml: one.guard: expected a finite number, got True"),
        ("published = 2", "publishd = 2", "unknown key in claims.toml: one 'publishd'"),
        ("[one]", "one = 3\n[two]", "claims.toml: one: expected a table, got 3"),
        ("[one]", "[one", "claims.toml: expected TOML"),
    ],
)
def test_a_bad_claim_is_named(tmp_path, old, new, message):
    with pytest.raises(InputError, match=re.escape(message)):
        claims(tmp_path, GOOD.replace(old, new))


@pytest.mark.parametrize("paper", PAPERS.values(), ids=lambda p: p.name)
def test_every_claim_of_every_paper_is_measured_once(paper):
    measures = [claim.measure for claim in paper.claims]
    assert len(set(measures)) == len(measures)
    assert set(measures) == set(paper.measures)
    assert all(claim.promise for claim in paper.claims if claim.kind == "at most")  # an upper bound holds or fails
