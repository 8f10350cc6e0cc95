"""Papers reproduced: the claims and their verdicts, the parts and their store, the report, Algorithm 4 side by side."""

import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imubench.errors import InputError
from imubench.estimators.olsson2020 import algorithm1
from imubench.estimators.plug_and_play import uniform_start
from imubench.estimators.uncertainty import Acceptance
from imubench.reproduce import PAPERS
from imubench.reproduce.claims import Claim, Judged, Measured, judge, load_claims
from imubench.reproduce.olsson2020 import data, experiments
from imubench.reproduce.olsson2020.figure7 import density
from imubench.reproduce.olsson2020.settings import E_MAX, settings
from imubench.reproduce.olsson2020.solving import Minima, acceptance, sequential_deviations, worst_of_last
from imubench.reproduce.paper import Figure, Paper, Part, Story, Table
from imubench.reproduce.parts import Store, run_parts
from imubench.reproduce.report import page
from imubench.reproduce.reproduce import reproduce

BOUNDED = Claim("c", "Errors are small", "section 1", 2.16, "deg", "at most", 2.16, "stated", "m", True)
SEEN = replace(BOUNDED, kind="about", published=90.0, limit=15.0, promise=False)
PAPER = PAPERS["olsson2020"]


def imubench(*words: object, folder: Path, limit: float = 300) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "imubench", *map(str, words)]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=limit)


# Claims


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
        ("limit = 2.5", "limit = nan", "claims.toml: one.limit: expected a finite number, got nan"),
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


# Parts and their store


def counted(n: int, log: str) -> dict[str, np.ndarray]:
    with Path(log).open("a") as file:
        file.write(f"{n}\n")
    return {"square": np.array([n * n])}


def failing() -> dict[str, np.ndarray]:
    raise ArithmeticError("no")


def counting_parts(log: Path, count: int = 3) -> list[Part]:
    return [Part(f"p{n}", "count", 1.0, counted, {"n": n, "log": str(log)}) for n in range(count)]


def test_finished_parts_are_not_computed_again(tmp_path):
    log, store, seen = tmp_path / "log", Store(tmp_path / "out", "settings"), []
    parts = counting_parts(log)
    with pytest.raises(ArithmeticError):
        run_parts([*parts[:2], Part("bad", "fail", 1.0, failing, {})], store, 0, lambda part: seen.append(part.name))
    assert seen == ["p0", "p1"]
    done = run_parts(parts, store, 0, lambda part: seen.append(part.name))
    assert {name: int(arrays["square"][0]) for name, arrays in done.items()} == {"p0": 0, "p1": 1, "p2": 4}
    assert log.read_text().split() == ["0", "1", "2"]
    assert seen == ["p0", "p1", "p0", "p1", "p2"]


def test_other_settings_and_broken_files_are_computed(tmp_path):
    log, out = tmp_path / "log", tmp_path / "out"
    parts = counting_parts(log, 1)
    first = Store(out, "settings")
    run_parts(parts, first, 0, lambda part: None)
    run_parts(parts, Store(out, "other settings"), 0, lambda part: None)
    assert log.read_text().split() == ["0", "0"]
    next(first.folder.glob("*.npz")).write_bytes(b"half a file")
    run_parts(parts, first, 0, lambda part: None)
    assert log.read_text().split() == ["0", "0", "0"]
    first.forget()
    assert [p.name for p in tmp_path.iterdir()] == ["log"]


def test_processes_give_what_one_process_gives(tmp_path):
    arguments = {"seed": 3, "number": 5, "w0": np.array([1.0, 50.0]), "starts": 4}
    parts = [Part(f"w{n}", "weights", 1.0, experiments.weighting, {**arguments, "number": n}) for n in (5, 6)]
    here = run_parts(parts, Store(tmp_path / "a", ""), 0, lambda part: None)
    there = run_parts(parts, Store(tmp_path / "b", ""), 2, lambda part: None)
    for name in here:
        # One thread of linear algebra or several may round sums differently; errors are 1e-4 rad.
        np.testing.assert_allclose(here[name]["deviation"], there[name]["deviation"], atol=1e-9)


# The report


@contextmanager
def unwatched(parts: list[Part]) -> Iterator[object]:
    yield lambda part: None


def drawn():
    from matplotlib.figure import Figure as Canvas

    canvas = Canvas(figsize=(2, 1))
    canvas.subplots().plot([0, 1], [0, 1])
    return canvas


def small_paper(limit: float) -> Paper:
    claim = replace(BOUNDED, limit=limit, measure="worst", claim="The error is < 2 deg & finite")
    return Paper(
        name="small",
        summary="a paper",
        citation="Somebody, Somewhere",
        claims=(claim, replace(SEEN, name="seen", measure="seen")),
        measures={"worst": lambda r: Measured(r, "of noise"), "seen": lambda r: Measured(r, "the rig is rigid")},
        settings=lambda quick, seed: (quick, seed),
        parts=lambda s: [Part("p", "sum", 1.0, counted, {"n": 1, "log": os.devnull})],
        gather=lambda s, done: float(done["p"]["square"][0]),
        tell=lambda r: Story(
            "Once upon a time",
            (
                Figure("f1", "Figure 1", "It goes up", "A line.", drawn),
                Table("t1", "Table 1", "It is one", "A number.", ("a", "b"), (("1", "2"),)),
            ),
            ("A note",),
        ),
    )


@pytest.mark.parametrize(("limit", "verdict"), [(2.0, "holds"), (0.5, "fails")])
def test_a_paper_becomes_claims_and_a_page_of_its_own(tmp_path, monkeypatch, limit, verdict):
    monkeypatch.setitem(PAPERS, "small", small_paper(limit))
    judged = reproduce("small", tmp_path / "out", quick=True, seed=0, watch=unwatched, workers=0)
    assert [j.verdict for j in judged] == [verdict, "differs"]
    assert [j["verdict"] for j in json.loads((tmp_path / "out" / "claims.json").read_text())] == [verdict, "differs"]
    text = (tmp_path / "out" / "report.html").read_text()
    for words in (
        "It goes up",
        "It is one",
        "Once upon a time",
        "A note",
        "the rig is rigid",
        "&lt; 2 deg &amp; finite",
    ):
        assert words in text
    block = "class='verdict bad'" if verdict == "fails" else "class='verdict good'"
    assert text.index("</h1>") < text.index(block) < text.index("What was done")  # the verdict comes first
    assert re.findall(r"<img alt='[^']*' src='data:image/png;base64,[A-Za-z0-9+/=]{400,}'>", text)
    assert not re.search(r"(src|href)=.(?!data:|#)", text)  # nothing from elsewhere
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_the_headline_counts():
    judged = [Judged(BOUNDED, Measured(1.0, "x"), v) for v in ("holds", "holds", "fails", "differs")]
    text = page(small_paper(1.0), Story("s", ()), judged, "how", "footer")
    assert "2 of 4 claims hold, 1 fails, 1 figure differs" in text


def test_exit_codes(tmp_path, monkeypatch, capsys):
    from rich.console import Console

    from imubench.cli_reproduce import run

    for limit, code in ((2.0, 0), (0.5, 1)):
        monkeypatch.setitem(PAPERS, "small", small_paper(limit))
        monkeypatch.setattr("imubench.reproduce.reproduce.cores", lambda: 0)
        assert run("small", tmp_path / f"out{code}", True, 0, Console(), Console(stderr=True)) == code
        assert ("fails" in capsys.readouterr().out) == bool(code)


def test_an_unknown_paper_is_exit_code_2(tmp_path):
    done = imubench("reproduce", "olson2020", "--out", "out", folder=tmp_path)
    assert done.returncode == 2
    assert "unknown paper 'olson2020'; known: olsson2020" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_without_matplotlib_one_line_says_so(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError, match=r"figures: expected matplotlib, got none; pip install 'imubench\[plot\]'"):
        reproduce("olsson2020", tmp_path / "out", quick=True, seed=0, watch=unwatched)
    assert list(tmp_path.iterdir()) == []


# Olsson 2020: many runs side by side


def random_runs(seconds: int = 60, runs: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Estimates that jump between two pairs of axes and both signs, and uncertainties around E_max."""
    rng = np.random.default_rng(1)
    pairs = rng.normal(size=(2, 2, 3))
    steps = rng.random((seconds, runs)) < 0.06
    which = np.cumsum(steps, axis=0) % 2
    axes = pairs[which] + rng.normal(scale=0.005, size=(seconds, runs, 2, 3))
    axes *= rng.choice([-1.0, 1.0], size=(seconds, runs, 1, 1)) / np.linalg.norm(axes, axis=-1, keepdims=True)
    return axes, E_MAX * rng.choice([0.5, 1.5], size=(seconds, runs, 2), p=[0.8, 0.2])


@pytest.mark.parametrize("n_min", [1, 3, 10])
def test_runs_side_by_side_are_accepted_as_algorithm_4_accepts_each(n_min):
    axes, local = random_runs()
    seqad = sequential_deviations(axes)
    worst, found = worst_of_last(seqad, n_min), acceptance(seqad, local, E_MAX, n_min)
    for m in range(axes.shape[1]):
        judge_one = Acceptance(E_MAX, n_min)
        verdicts = [judge_one.update(a, u) for a, u in zip(axes[:, m], local[:, m], strict=True)]
        np.testing.assert_array_equal(seqad[:, m], [v.seqad for v in verdicts])
        np.testing.assert_array_equal(worst[:, m], [v.worst_seqad for v in verdicts])
        assert found[m] == next((t for t, v in enumerate(verdicts) if v.accepted), -1)
    assert (found >= 0).any()


def test_starts_that_share_a_minimum_get_what_algorithm_1_gives_them():
    c = data.weighed(data.selections("sequence3", 0, 125)[15])
    rng = np.random.default_rng(2)
    minima = Minima(c, np.random.default_rng(3))
    for _ in range(20):
        start = uniform_start(rng)
        # 1e-6 rad is what counts as one minimum; an answer may then be that far off twice.
        np.testing.assert_allclose(minima.estimate(start)[0], algorithm1(c, start)[0].axes, atol=2e-6)
    assert len(minima._known) < 10


def test_how_the_work_is_cut_changes_nothing():
    whole = experiments.runs(0, "sequence3", 125, 10, 14, 3)
    cut = [experiments.runs(0, "sequence3", 125, a, b, 3) for a, b in ((10, 12), (12, 14))]
    for key in ("axes", "local"):
        np.testing.assert_array_equal(whole[key], np.concatenate([c[key] for c in cut]))
    runs = experiments.biased_runs(0, "sequence3", 125, 0, 2)
    second = experiments.biased_runs(0, "sequence3", 125, 1, 2)
    np.testing.assert_array_equal(runs["axes"][:, 1:], second["axes"])
    assert np.isnan(runs["axes"][-1]).all()  # accepted long before the end, where a run ends


def test_the_grid_holds_both_pairings_alike():
    starts = experiments.grid_starts(36)
    assert len(np.unique(starts.round(9), axis=0)) == 36
    assert len(experiments.grid_starts(12)) == 12


def test_density_counts_held_samples():
    held = np.array([[0, 1, -1], [0, 26, 30]])
    np.testing.assert_allclose(density(held, 60), np.array([[2, 0, 0], [1, 2, 0]]) / 25)  # sums of 1 / 25 round


def test_quick_is_the_same_work_but_less():
    quick, full = PAPER.parts(settings(True, 0)), PAPER.parts(settings(False, 0))
    assert {part.run for part in quick} == {part.run for part in full}
    assert {part.stage for part in quick} == {part.stage for part in full}
    assert sum(part.work for part in quick) < 0.2 * sum(part.work for part in full)
    for parts in (quick, full):
        assert len({part.name for part in parts}) == len(parts)


@pytest.fixture(scope="module")
def quick_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """One quick run that is interrupted on its way and goes on."""
    folder = tmp_path_factory.mktemp("reproduce")
    command = [sys.executable, "-m", "imubench", "reproduce", "olsson2020", "--quick", "--out", "out"]
    first = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for _ in range(600):
        if len(list(folder.glob(".out.parts/*/*.npz"))) > 5:
            break
        time.sleep(0.1)
    first.send_signal(signal.SIGINT)
    _, errors = first.communicate(timeout=60)
    assert first.returncode == 130
    assert "the same command goes on from there" in errors
    assert [p.name for p in folder.iterdir()] == [".out.parts"]
    before = {p.name: p.stat().st_mtime_ns for p in folder.glob(".out.parts/*/*.npz")}
    assert len(before) > 5
    return folder / "out", imubench(*command[3:], folder=folder)


@pytest.mark.slow
def test_quick_reproduces_every_figure_and_claim(quick_run):
    out, done = quick_run
    entries = json.loads((out / "claims.json").read_text())
    assert [e["name"] for e in entries] == [claim.name for claim in PAPER.claims]
    assert all(e["why"] for e in entries)
    assert done.returncode == int(any(e["verdict"] == "fails" for e in entries)), done.stderr
    text = (out / "report.html").read_text()
    for name in ("figure2", "figure4", "figure5", "figure6", "figure7", "figure8", "table1", "sessions"):
        assert f"id='{name}'" in text
    assert text.count("data:image/png;base64,") == 6
    assert not re.search(r"(src|href)=.(?!data:|#)", text)
    assert not list(out.parent.glob(".*"))  # parts, partial folders: all gone


@pytest.mark.slow
def test_quick_keeps_the_bounds_that_a_rigid_rig_must_keep(quick_run):
    """Regression: what holds with any seed because the rig is rigid and the method is right."""
    entries = {e["name"]: e for e in json.loads((quick_run[0] / "claims.json").read_text())}
    for name in ("fig5-plateau", "fig5-slow-planar", "fig6-sequence1-1000", "fig6-sequence1-125", "fig7-gyro"):
        assert entries[name]["verdict"] == "holds", entries[name]
    assert entries["accepted-10-sequence3"]["measured"] == 100
