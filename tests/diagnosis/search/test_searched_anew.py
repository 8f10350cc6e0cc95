"""What is dropped in the end, and hid something, is not the end of the search."""

from dataclasses import replace

import pytest

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search import selection as module
from imubench.diagnosis.search.admission import Add
from imubench.diagnosis.search.moves.drop import Drop
from imubench.diagnosis.search.moves.move import Proposal
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

FILTER = Hypothesis(EFFECTS["low_pass"], "imu1")
BIAS = Hypothesis(EFFECTS["gyro_bias"], "imu1")
MOUNT = Hypothesis(EFFECTS["soft_mount"], "imu1")


def iter_of(state):
    """A move's proposals: one state, always taken, of which is known what it can do without."""
    yield Proposal("it", replace(state, weighed=state.fit))


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean")
    make_case(folder / "r", "pendulum", [], 5, seconds=6.0)
    return nominal_fit(read(folder / "r")[0])


@pytest.mark.parametrize(
    ("dropped", "puzzling", "rounds"), [(FILTER, True, 2), (FILTER, False, 1), (BIAS, True, 1), (None, True, 1)]
)
def test_the_search_goes_on_without_a_state_that_was_dropped(fit, dropped, puzzling, rounds, monkeypatch):
    asked = []

    def searched(_, state):
        asked.append({h.name for h in state.everything})
        memory = replace(state.rounds, again=False)
        yield Proposal("a round", replace(state, refused=(*state.refused, (MOUNT, float(len(asked)))), rounds=memory))

    gone = iter([((dropped, 0.0),) if dropped else ()])
    monkeypatch.setattr(Add, "propose", searched)
    monkeypatch.setattr(module, "suspicious", lambda now: puzzling)
    monkeypatch.setattr(Drop, "propose", lambda _, state: iter_of(state.without(next(gone, ()), state.fit)))
    found = module.select(fit)
    assert len(asked) == rounds
    assert {MOUNT.name, "low_pass[accel]@imu1"} <= asked[-1]  # of another triple it is another filter
    assert (FILTER.name in asked[-1]) == (rounds == 1)
    assert [nat for h, nat in found.rejected if h is MOUNT] == [float(n + 1) for n in range(rounds)]


@pytest.mark.parametrize("finer", [True, False])
def test_what_was_certain_before_the_knots_became_finer_stays(fit, finer, monkeypatch):
    asked = []

    def drop(_, state):
        asked.append(list(state.firm))
        yield Proposal("nothing", replace(state, weighed=state.fit))

    def nothing_more(_, state):
        yield Proposal("a round", replace(state, rounds=replace(state.rounds, again=False)))

    monkeypatch.setattr(Add, "propose", nothing_more)
    monkeypatch.setattr(module, "suspicious", lambda now: False)
    monkeypatch.setattr(module, "finer", lambda now: replace(now) if finer else now)
    monkeypatch.setattr(module, "firmly", lambda *_: [BIAS])
    monkeypatch.setattr(Drop, "propose", drop)
    module.select(fit)
    assert asked == [[BIAS] if finer else []]
