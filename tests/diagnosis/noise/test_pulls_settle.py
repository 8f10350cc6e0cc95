"""Pulls on a law's number that lead beyond, and back, are halved until it stays."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from imubench.diagnosis.noise import reml
from imubench.diagnosis.problem.hypothesis import Prior, State

NAME = "soft_mount@imu1.damping_ratio"


@dataclass(frozen=True)
class Springs:
    """A model of one number, as far as the rounds of noise levels ask."""

    tilts: dict | None = None
    least: dict = field(default_factory=dict)
    hypotheses: tuple = ()
    tracks: object = field(default_factory=lambda: SimpleNamespace(knots=SimpleNamespace(count=10)))


@pytest.fixture
def rounds(monkeypatch):
    """A function of how far a whole pull leads, over the way to the best number: the number after every round."""

    def run(length, most):
        numbers = []

        def search(model, state, noise, anchor, **_):
            value = model.tilts[NAME].start if model.tilts else state.values[NAME]
            numbers.append(float(value[0]))
            return SimpleNamespace(state=State(np.zeros((1, 1)), {NAME: value}), noise=noise, steps=1), None

        def estimated(fit, step, names, share):
            value = fit.state.values[NAME]
            return {}, {NAME: Prior(value - share * length * (value - 0.5), np.ones(1))}

        monkeypatch.setattr(reml, "search", search)
        monkeypatch.setattr(reml, "_estimated", estimated)
        monkeypatch.setattr(reml, "declared", lambda model: {})
        monkeypatch.setattr(reml, "law_parameters", lambda fit: [NAME])
        start = State(np.zeros((1, 1)), {NAME: np.full(1, 1.5)})
        reml.fit_with_noise(Springs(), start, {"imu1.gyro": 1.0}, None, most)
        return np.array(numbers)

    return run


def test_a_pull_that_leads_to_the_number_is_taken_whole(rounds):
    assert rounds(1.0, 8) == pytest.approx([1.5, 0.5, 0.5])


def test_pulls_that_lead_beyond_come_to_rest(rounds):
    """Whole ones would leave it 1.2 times as far off each time."""
    numbers = rounds(2.2, 12)
    assert numbers[1] < 0.5  # beyond
    assert len(numbers) < 12
    assert abs(numbers[-1] - 0.5) < reml.REML.settled


def test_pulls_that_go_on_the_same_way_stay_whole(rounds):
    off = rounds(0.5, 4) - 0.5
    assert off[2:] / off[1:-1] == pytest.approx(0.5)
