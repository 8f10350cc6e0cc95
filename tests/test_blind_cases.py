"""The benchmark of blind cases: which are asked, what is kept of them, and what they add up to. No case is run."""

from dataclasses import asdict

import pytest

from benchmarks import blind_cases
from benchmarks.blind_cases import CASE, Scored, asked_right, cases, kept, questions, samples, table
from imubench.answers import write_json
from imubench.terminal import Terminal
from imubench.trials.replayed import Replayed


def scored(name="000", failed="", found=("gyro_bias at imu1 (0.98)",), **replay):
    return Scored(name, "hinge", 20.0, ("gyro_bias at imu1",), found, failed, 12.0, "abc", Replayed(**replay))


def test_sixty_with_something_in_them_that_shows_short_ones_first():
    asked = questions(60, 5, 20.0)
    assert len(asked) == 60
    assert all(q.effects and q.observable and q.options["seconds"] <= 20.0 for q in asked.values())
    sizes = [samples(q) for q in asked.values()]
    assert sizes == sorted(sizes)
    assert {q.kind for q in asked.values()} == {"one", "several"}
    assert questions(60, 5, 20.0) == asked != questions(60, 6, 20.0)


def test_what_is_kept_is_not_run_again_and_nothing_is_begun_without_time(tmp_path, monkeypatch):
    asked = questions(3, 5, 20.0)
    first, second, third = asked
    done = scored(first, replay=1.02, modelled=True, sensor=True, first_channel=None, channel="imu1.gyr_x")
    (tmp_path / first).mkdir()
    write_json(tmp_path / first / CASE, asdict(done))
    assert kept(first, tmp_path) == done and kept(second, tmp_path) is None
    run = []
    monkeypatch.setattr(blind_cases, "asked", lambda name, question, out: run.append(name) or scored(name))
    assert list(cases(asked, tmp_path, 0.0, Terminal(stderr=True))) == [done]
    assert [s.name for s in cases(asked, tmp_path, float("inf"), Terminal(stderr=True))] == [first, second, third]
    assert run == [second, third]


def test_a_failure_counts_as_wrong_and_what_does_not_arise_as_nothing():
    every = [
        scored("000", replay=1.05, modelled=True, sensor=True, first_channel=True),
        scored("001", replay=1.3, modelled=False, sensor=True, first_channel=False),
        scored("002", sensor=False, first_channel=None),  # the name is wrong
        scored("003", found=()),  # nothing found
        scored("004", failed="stopped", found=()),
    ]
    sensor, channel, near = asked_right(every).values()
    assert (sorted(sensor), sorted(channel), near) == ([False, False, True, True], [False, False, True], [True, False])
    text = table(every, 60, 20.0)
    assert "**5 of 60 cases were run**" in text and "1 of them nothing was found" in text
    assert "| first sensor of `where` right | 2 of 4, 50% " in text and "| open |" in text
    assert "| open |" not in table(every, 5, 20.0) and "| **no** |" in table(every, 5, 20.0)
    assert "**1.30**" in text and "| stopped |" in text


@pytest.mark.parametrize("scores", [[], [scored(found=())]])
def test_without_an_answer_nothing_is_met_nor_missed(scores):
    assert "none | 90% | - |" in table(scores, 60, 20.0)
