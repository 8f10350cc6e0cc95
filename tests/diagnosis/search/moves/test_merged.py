"""Two effects that are parts of one, and two that are not, on recordings of the independent generator."""

import pytest

from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.merge import Merge
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case
from tests.searching import moved

SLIDING = ("skin_sliding", "imu2", {"slide": [0.0, 0.004, 0.002], "twist": [-0.001, 0.018, -0.007]})


def fitted_with(folder, asked, names):
    """The fit of a recording with effects `asked`, and effects `names` in its model, as the search would keep them."""
    make_case(folder / "case", "hinge", effects=asked, seed=11, seconds=12.0)
    fit = nominal_fit(read(folder / "case")[0])
    held = tuple(Hypothesis(EFFECTS[name].suited(fit.model.recording), at) for name, at in names)
    fit = with_noise(refit(fit, held), 1)
    return fit, [Kept(h, 100.0, None, ()) for h in held]


def names_of(fit, kept):
    """What a fit and its list of effects hold: the same."""
    held = {(h.effect.name, h.at) for h in fit.model.hypotheses}
    assert {(k.hypothesis.effect.name, k.hypothesis.at) for k in kept} == held
    return held


@pytest.mark.long
def test_an_axis_that_turns_and_a_centre_that_moves_are_one_imu_that_slides(tmp_path):
    parts = [("axis_coupling", "joint"), ("moving_centre", "joint")]
    fit, kept = fitted_with(tmp_path, [SLIDING], parts)
    state = moved(Merge(), fit, kept)
    assert names_of(state.fit, state.kept) == {("skin_sliding", "imu2")}
    (decision,) = state.use.decisions
    assert decision.what == "skin_sliding@imu2 in the place of axis_coupling@joint and moving_centre@joint"


@pytest.mark.long
@pytest.mark.parametrize(
    "asked",
    [
        [("accel_bias", "imu1"), ("gyro_scale", "imu2")],
        pytest.param([("axis_coupling", "joint"), ("accel_bias", "imu2")], marks=pytest.mark.slow),
        pytest.param([("mount_pose", "imu1"), ("gyro_bias", "imu1")], marks=pytest.mark.slow),
    ],
)
def test_two_that_are_there_stay_two(tmp_path, asked):
    fit, kept = fitted_with(tmp_path, asked, asked)
    state = moved(Merge(), fit, kept)
    assert names_of(state.fit, state.kept) == set(asked)
