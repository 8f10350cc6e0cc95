"""What the search does once it has more knots."""

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

BIAS = Hypothesis(EFFECTS["gyro_bias"], "imu1")


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean")
    make_case(folder / "r", "pendulum", [], 5, seconds=6.0)
    return nominal_fit(read(folder / "r")[0])


@pytest.mark.parametrize("finer", [True, False])
def test_what_was_certain_before_the_knots_became_finer_stays(fit, finer, monkeypatch):
    asked = []

    def drop(_, state):
        asked.append(list(state.firm))
        yield Proposal("nothing", replace(state, weighed=state.fit))

    def nothing_more(_, state):
        yield Proposal("a round", replace(state, rounds=replace(state.rounds, again=False)))

    monkeypatch.setattr(Add, "propose", nothing_more)
    monkeypatch.setattr(module, "finer", lambda now: replace(now) if finer else now)
    monkeypatch.setattr(module, "firmly", lambda *_: [BIAS])
    monkeypatch.setattr(Drop, "propose", drop)
    module.select(fit)
    assert asked == [[BIAS] if finer else []]
