"""ArVE_d reproduced: the fit, the runs, the claims and their guards, and a wrong sign that must not pass."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks.pendulum_runs import R_VARIES, circling
from imubench.errors import InputError
from imubench.estimators.centre_ekf import A_, R_, W_, stored
from imubench.estimators.centre_runs import _Runs
from imubench.reproduce.arve import PAPER, experiments, fit, results
from imubench.reproduce.arve.results import Results
from imubench.reproduce.arve.runs import WAYS, noisy, played, removed
from imubench.reproduce.arve.settings import Settings, settings
from imubench.reproduce.claims import Judged, judge
from imubench.scenarios.pendulum import R_AMPLITUDE

SEEDS = np.arange(10)


# --- the fit ---


@pytest.mark.long
@pytest.mark.parametrize("name", ["arve", "arve-d"])
def test_the_stored_covariances_are_those_of_the_fit(name):
    for key, value in fit.fitted(name).items():
        assert stored()[name]["varying"][key] == pytest.approx(value, rel=0.02)  # three digits; a flat minimum


def test_no_run_that_is_judged_has_the_seed_of_the_fit():
    for seed in (0, 1, 7):
        assert fit.SEED not in settings(False, seed).seeds()


# --- the runs ---


def test_the_motion_is_that_of_an_independent_pendulum():
    ours, theirs = noisy(played(varying=True), 3), circling(np.random.default_rng(0), amplitude=R_VARIES)
    assert_allclose(ours.truth.gyro, theirs.rate, atol=1e-9)  # two derivations in closed form
    assert_allclose(ours.r, theirs.r, atol=1e-9)
    acceleration = removed(ours, "known")[0] - (ours.accel[0] - ours.truth.specific_force)
    exact = circling(np.random.default_rng(0), amplitude=R_VARIES, noise=(0.0, 0.0)).acceleration[0]
    assert_allclose(acceleration, exact, atol=1e-8)  # as above, gravity taken out and put back


def test_a_run_is_its_seed():
    both, second = noisy(played(False), [4, 5]), noisy(played(False), 5)
    assert (both.gyro[1] == second.gyro[0]).all()
    assert np.std(both.gyro - both.truth.gyro) == pytest.approx(0.0017, rel=0.03)  # 6000 numbers: 0.9 % once
    assert np.std(both.accel - both.truth.specific_force) == pytest.approx(0.02, rel=0.03)


@pytest.mark.parametrize(
    ("way", "low", "high"),
    [
        ("known", 0.0, 0.0),
        ("told", 0.002, 0.01),  # 0.005 measured: a milliradian of tilt is 0.01
        ("late", 0.07, 0.14),  # half a sample at 1 to 1.9 rad/s, about level axes for the most part, times 9.81 m/s^2
    ],
)
def test_what_is_left_of_gravity(way, low, high):
    runs = noisy(played(False), SEEDS)
    left = np.linalg.norm(removed(runs, way) - removed(runs, "known"), axis=-1).mean()  # m/s^2
    assert low <= left <= high


def test_an_unknown_way_is_named():
    with pytest.raises(InputError, match=f"unknown gravity removal 'magic'; known: {', '.join(WAYS)}"):
        removed(noisy(played(False), 0), "magic")


def test_components_that_swing_apart_are_farther_from_any_constant():
    turn = np.linspace(0, 2 * np.pi, 1000, endpoint=False)[:, None]
    together = np.linalg.norm(R_AMPLITUDE * np.sin(turn), axis=1).mean()
    assert together == pytest.approx(2 / np.pi * np.linalg.norm(R_AMPLITUDE), rel=1e-5)  # a Riemann sum of a kink
    for phases in np.random.default_rng(0).uniform(0, 2 * np.pi, size=(50, 3)):
        assert np.linalg.norm(R_AMPLITUDE * np.sin(turn + phases), axis=1).mean() >= together - 1e-9


# --- claims, guards, and a wrong sign ---


@pytest.fixture(scope="module")
def clean() -> Results:
    """The quick run without the parts that only words are taken from."""
    s = Settings(True, 0, 10, ("known",))
    done = {name: experiments.setup(SEEDS[:1], name) for name in ("late", "untold-one-sided", "flat")}
    gravity = {"known": experiments.gravity(SEEDS, "known")}
    initials = experiments.initials(SEEDS)["errors"]
    return Results(
        s, experiments.windows(SEEDS), initials, experiments.blind(SEEDS), experiments.varying(SEEDS), gravity, done
    )


def judged(r: Results) -> list[Judged]:
    return [judge(claim, PAPER.measures[claim.measure](r)) for claim in PAPER.claims]


@pytest.mark.long
def test_all_promises_hold_and_no_guard_is_passed(clean):
    found = judged(clean)
    assert [j.claim.name for j in found if j.news] == []
    assert {j.claim.name for j in found if j.verdict == "fails"} == set()
    differ = {j.claim.name for j in found if j.verdict == "differs"}
    assert {"fig4-45", "fig4-45-max", "fig5-still", "fig6-60", "fig9-sphere", "table1-mrvs-distance-mean"} <= differ
    assert all(len(j.measured.why) > 10 for j in found)  # every claim has words


def flipped(block):
    """_Runs._linearise with the sign of one block of the Jacobian wrong; what it expects to measure stays right."""
    right = _Runs._linearise

    def wrong(self):
        expected = right(self)
        self._J[:, block] *= -1
        return expected

    return wrong


@pytest.mark.long
@pytest.mark.parametrize("block", [R_, W_, A_], ids=["da/dr", "da/dw", "da/dw'"])
def test_a_wrong_sign_in_one_block_of_the_jacobian_is_noticed(clean, monkeypatch, block):
    monkeypatch.setattr(_Runs, "_linearise", flipped(block))
    with np.errstate(all="ignore"):  # a filter that breaks down makes numbers that are none
        initials = experiments.initials(SEEDS)["errors"]
        broken = Results(
            clean.settings,
            clean.windows,
            initials,
            experiments.blind(SEEDS),
            experiments.varying(SEEDS),
            clean.gravity,
            clean.setups,
        )
        assert [j.claim.name for j in judged(broken) if j.news]


def test_quick_is_the_same_work_but_less():
    quick, full = results.parts(settings(True, 0)), results.parts(settings(False, 0))
    assert [p.name for p in quick] == [p.name for p in full]
    assert len(quick[0].arguments["seeds"]) < len(full[0].arguments["seeds"]) == 100


# --- the command ---


@pytest.mark.slow
def test_quick_reproduces_every_figure_and_claim(tmp_path):
    command = [sys.executable, "-m", "imubench", "reproduce", "arve", "--quick", "--out", "out"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    entries = json.loads((tmp_path / "out" / "claims.json").read_text())
    assert [e["name"] for e in entries] == [claim.name for claim in PAPER.claims]
    text = (tmp_path / "out" / "report.html").read_text()
    names = [*(f"figure{n}" for n in range(4, 10)), "table1", "gravity", "readings"]
    assert all(f"id='{name}'" in text for name in names)
    assert text.count("data:image/png;base64,") == 6
    assert not re.search(r"(src|href)=.(?!data:|#)", text)  # nothing from elsewhere


@pytest.mark.slow
def test_a_wrong_sign_makes_the_command_fail(tmp_path, monkeypatch):
    from rich.console import Console

    from imubench.commands.work.reproduce import run

    monkeypatch.setattr(_Runs, "_linearise", flipped(A_))
    monkeypatch.setattr("imubench.reproduce.reproduce.cores", lambda: 0)  # in this process, where the sign is wrong
    with np.errstate(all="ignore"):
        assert run("arve", tmp_path / "out", True, 0, Console(quiet=True), Console(quiet=True)) == 1
