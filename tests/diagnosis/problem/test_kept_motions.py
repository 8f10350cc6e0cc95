"""A motion that is kept is the one that would be made anew, and another one once anything that moves it has changed."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem import kept_motions
from imubench.diagnosis.problem.bspline import KEPT_LONG_BASES
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.kept_motions import KeptMotions
from imubench.diagnosis.solve.refit import extended
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.jets import derivatives_by
from imubench.proof.case import make_case

PLAY, GRAVITY, CLOCK = (
    Hypothesis(EFFECTS[name], at)
    for name, at in (("joint_play", "joint"), ("gravity", "world"), ("time_offset", "imu2"))
)


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kept") / "r"
    make_case(folder, "hinge", [], 4, seconds=4.0, rate=50.0)
    return extended(nominal_fit(read(folder)[0]), (PLAY, GRAVITY, CLOCK))


def moved(fit, state):
    moment = fit.model.moment(state, fit.model.recording.imus[1].time, "imu2")
    return fit.model.last(state, moment)


def spline(name):
    def change(fit):
        coefficients = fit.state.coefficients.copy()
        coefficients[40:60, fit.model.tracks.columns(name)] += 0.01
        return replace(fit.state, coefficients=coefficients)

    return change


def number(h):
    def change(fit):
        name = h.key(h.effect.parameters[0].name)
        return replace(fit.state, values=fit.state.values | {name: fit.state.values[name] + 0.01})

    return change


@pytest.mark.parametrize(
    "change",
    [spline("attitude"), spline("force"), spline("hinge"), spline(PLAY.key(PLAY.effect.states[0].name)), number(CLOCK)],
)
def test_what_moves_a_segment_makes_another_motion(begun, change):
    first, other = moved(begun, begun.state), moved(begun, change(begun))
    assert moved(begun, begun.state) is first
    assert any(np.any(getattr(first, part).value != getattr(other, part).value) for part in ("rate", "accel", "force"))


def test_derivatives_that_are_not_asked_for_are_not_there(begun):
    whole = moved(begun, begun.state)
    with derivatives_by(("hinge",)):
        part = moved(begun, begun.state)
    assert {name for name, _ in part.rate.blocks} == {"hinge"}
    assert {name for name, _ in whole.rate.blocks} > {"hinge"}
    assert moved(begun, begun.state).rate.blocks.keys() == whole.rate.blocks.keys()


def test_it_is_what_is_made_anew(begun, monkeypatch):
    kept = moved(begun, begun.state)
    monkeypatch.setattr(kept_motions, "LONG_TIMES", 0)
    anew = moved(begun, begun.state)
    assert anew is not kept
    for part in ("rate", "accel", "force"):
        one, other = getattr(kept, part), getattr(anew, part)
        assert_array_equal(one.value, other.value)
        assert all(np.array_equal(d, other.blocks[key]) for key, d in one.blocks.items())


def test_only_the_last_are_kept():
    kept, made = KeptMotions(), []
    for key in [*range(KEPT_LONG_BASES + 1), KEPT_LONG_BASES, 0]:
        kept.get(key, lambda key=key: made.append(key) or {})
    assert made == [*range(KEPT_LONG_BASES + 1), 0]
