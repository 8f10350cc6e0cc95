"""A diagnosis stops at its limit of processor time, says what is known by then and what was not tried."""

import threading
from dataclasses import dataclass, replace

import numpy as np
import pytest

from imubench.correction.corrected import removal
from imubench.diagnosis import budget as module
from imubench.diagnosis import on_disk, pipeline
from imubench.diagnosis.budget import Budget, OutOfTime, check
from imubench.diagnosis.config.verdict import BUDGET
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.report import words
from imubench.diagnosis.residual_checks.fit_summary import weighed
from imubench.diagnosis.result import Finding, Interval
from imubench.diagnosis.result_file import as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.diagnosis.search.moves.drop import Drop
from imubench.diagnosis.search.selection import FURTHER, STAGES, WITHOUT, select
from imubench.diagnosis.solve.threads import side_by_side
from imubench.diagnosis.verdict.timed_out import HALVES_AGREE, doubted_as_stopped, verdict_when_stopped, with_rest
from imubench.errors import InputError
from imubench.format1 import read, write_recording
from imubench.proof.case import make_case
from imubench.reproduce.report import escape
from tests import command


@pytest.fixture(scope="module")
def biased(tmp_path_factory):
    """A hinge of 12 s at 50 Hz whose second gyroscope has a bias and whose first accelerometer a scale."""
    folder = tmp_path_factory.mktemp("limit") / "r"
    make_case(folder, "hinge", [("gyro_bias", "imu2"), ("accel_scale", "imu1")], 5, "strong", seconds=12.0, rate=50.0)
    return read(folder)[0]


@pytest.fixture(scope="module")
def fit(biased):
    return nominal_fit(biased)


@dataclass
class Clock:
    """Processor time that passes only while work asks for it: how much is done counts, not how fast the machine is."""

    now: float = 0.0  # s
    tick: float = 0.01  # s that pass each time it is asked
    asked: int = 0

    def __call__(self) -> float:
        self.asked += 1
        self.now += self.tick
        return self.now


@pytest.fixture
def clock(monkeypatch):
    """The budget's clock, which a test has in its hands."""
    made = Clock()
    monkeypatch.setattr(module, "process_time", made)
    monkeypatch.setattr(on_disk, "process_time", made)
    return made


# The budget


def test_without_a_limit_nothing_is_ever_stopped():
    with Budget().part(0.0, "nothing"):
        check()
    check()


def test_a_part_ends_at_its_share_and_says_what_was_not_tried(clock):
    budget = Budget(0.2)
    done = []
    with budget.part(0.5, "the rest"):
        while True:
            check()
            done.append(1)
    assert len(done) in (9, 10)  # ticks of 0.01 s in half of 0.2 s: the last one is a matter of rounding
    assert budget.not_tried == ["the rest"]
    assert budget.stopped == "time limit of 0.2 s of processor time"
    check()  # outside the part nothing is stopped


def test_a_part_within_a_part_ends_no_later():
    outer = Budget(0.0)
    inner = Budget(1e6)
    with outer.part(1.0, "all of it"):
        with inner.part(1.0, "a piece of it"):
            check()
        check()
    assert (outer.not_tried, inner.not_tried) == (["all of it"], ["a piece of it"])


def test_other_errors_go_through():
    budget = Budget(100.0)
    with pytest.raises(ZeroDivisionError), budget.part(1.0, "nothing"):
        raise ZeroDivisionError
    assert budget.not_tried == []


def test_work_on_threads_counts_and_is_stopped(monkeypatch, clock):
    """The time of all threads is the processor time, and pieces that have not begun do not begin."""
    monkeypatch.setattr("imubench.diagnosis.solve.threads.CORES", 2)
    budget, begun = Budget(0.2), []

    def piece(i: int) -> int:
        begun.append(threading.current_thread().name)
        clock.now += 0.05
        return i

    with budget.part(1.0, "pieces"):
        list(side_by_side(piece, range(1000)))
    assert budget.not_tried == ["pieces"]
    assert 2 <= len(begun) <= 4  # of 0.05 s each, and a tick, in 0.2 s


# A fit and a search


def test_a_single_fit_is_stopped_between_its_steps(biased):
    """The Gauss-Newton loop asks, and the pieces of its equations do."""
    budget = Budget(0.0)
    with budget.part(1.0, "the fit"):
        nominal_fit(biased)
    assert budget.not_tried == ["the fit"]


@pytest.mark.long
def test_a_search_that_is_stopped_hands_on_what_it_has(fit):
    whole = select(fit)
    assert {k.hypothesis.effect.name for k in whole.kept} == {"gyro_bias", "accel_scale"}
    assert whole.not_tried == ()
    with Budget(0.0).part(1.0, "the search"):
        nothing = select(fit)
    assert nothing.not_tried == tuple(stage.name for stage in STAGES)
    assert nothing.fit is fit
    assert nothing.kept == ()


@pytest.mark.long
def test_what_a_search_found_before_it_was_stopped_is_kept(fit, monkeypatch):
    """The first look at whether each finding is needed comes too late: everything found before stays."""

    def too_late(*_: object) -> None:
        raise OutOfTime

    monkeypatch.setattr(Drop, "propose", too_late)
    found = select(fit)
    assert {k.hypothesis.effect.name for k in found.kept} >= {"gyro_bias", "accel_scale"}
    assert {h.name for h in found.fit.model.hypotheses} == {k.hypothesis.name for k in found.kept}
    assert FURTHER not in found.not_tried
    assert found.not_tried[0] == WITHOUT


# What is said


def named(effect: str = "gyro_bias", sure: float = 0.96) -> Finding:
    return Finding(effect, "imu2", sure, {}, Interval(100.0, (90.0, 110.0)))


def test_findings_of_a_search_that_was_stopped_are_doubted():
    assert [f.confidence for f in doubted_as_stopped((named(), named(sure=0.5)))] == [0.6, 0.5]


def test_no_mismatch_is_never_said_of_a_search_that_was_stopped(fit):
    """Nor explained while more than noise is left, nor anything but the verdicts that go with the findings."""
    far = weighed(fit, {})
    quiet = replace(far, levels=tuple(replace(level, left=level.used) for level in far.levels))
    assert far.misfit > 1.4
    (rest,) = with_rest((), far)
    assert rest.effect == "unknown"
    assert rest.where is not None
    assert verdict_when_stopped((), (rest,), far)[0] == "unexplained"
    assert verdict_when_stopped((named(),), (rest,), far)[0] == "partly explained"
    verdict, unseen = verdict_when_stopped((), (), quiet)
    assert verdict == "unobservable"
    assert "--time-limit" in unseen[0].motion


@pytest.mark.parametrize("limit", [0.5, pytest.param(6.0, marks=pytest.mark.long)])
def test_a_diagnosis_keeps_its_limit_and_says_so(biased, limit, tmp_path, clock):
    write_recording(biased, tmp_path / "rec")
    done = on_disk.diagnose_on_disk(tmp_path / "rec", tmp_path / "out", time_limit=limit)
    # each part that is due after the limit asks once and ends, in two threads at most
    assert clock.now < limit + 40 * clock.tick
    said = done.diagnosis
    assert said.stopped == f"time limit of {limit:g} s of processor time"
    assert said.not_tried
    assert said.verdict in ("partly explained", "unexplained", "unobservable")
    assert all(f.confidence <= 0.6 for f in said.findings if f.effect in ("gyro_bias", "accel_scale"))
    again = read_diagnosis(tmp_path / "out")
    assert as_dict(again) == as_dict(said)
    assert escape(words.stopped(said)) in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
def test_within_its_limit_a_diagnosis_is_as_without(biased):
    free, bound = (diagnose(biased, budget=Budget(limit))[0] for limit in (np.inf, 1e4))
    assert bound.stopped == ""
    assert bound.not_tried == ()
    assert {k: v for k, v in as_dict(free).items() if k != "seconds"} == {
        k: v for k, v in as_dict(bound).items() if k != "seconds"
    }


@pytest.mark.long
def test_the_command_takes_a_limit_and_prints_what_was_not_tried(biased, tmp_path):
    write_recording(biased, tmp_path / "rec")
    words_of = ("diagnose", "rec", "--out", "out", "--time-limit", "5")
    done = command.imubench(*words_of, folder=tmp_path, limit=600, OMP_NUM_THREADS="1", COLUMNS="200")
    assert done.returncode == 0, done.stderr
    assert "Stopped at the time limit of 5 s of processor time; not tried:" in done.stdout
    text = command.imubench("diagnose", "--help", folder=tmp_path, limit=100, COLUMNS="200").stdout
    assert "--time-limit" in text
    assert f"{BUDGET.limit_s:.1f}" in text


def test_what_was_not_asked_whether_its_halves_agree_is_not_taken_out(biased, monkeypatch):
    def late(*_):
        raise OutOfTime

    monkeypatch.setattr(pipeline, "doubts", late)
    said, _ = diagnose(biased, budget=Budget(600.0))
    assert HALVES_AGREE in said.not_tried
    assert said.verdict == "partly explained"
    with pytest.raises(InputError, match=r"no time to ask whether the halves"):
        removal(biased, said)
