"""Effects as small as they are: what they promise, and a faint one that was something without a name."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.criteria.score_at_size import SIZES_OF_PRIOR, scores_at_size
from imubench.diagnosis.criteria.score_test import score
from imubench.diagnosis.discrepancy.fitted_terms import fitted_term
from imubench.diagnosis.discrepancy.term_scores import promising
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.search.unknown import finding
from imubench.diagnosis.search.unknown_against_small import nearly_straight, with_equals
from imubench.diagnosis.search.unnamed import Unknowns
from imubench.diagnosis.solve.schur import Base
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

ASKED = [Hypothesis(EFFECTS[name], "imu2") for name in ("gyro_misalignment", "accel_bias", "g_sensitivity")]


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sized") / "case"
    faint = {"matrix": [-0.004, -0.005, 0.004, -0.003, -0.005, -0.005]}
    make_case(folder, "hinge", [("gyro_misalignment", "imu2", faint)], 8, seconds=6.0, rate=50.0)
    return nominal_fit(read(folder)[0])


@pytest.mark.long
def test_what_effects_promise_is_what_the_search_says_of_priors_of_every_size(fit):
    """The search solves for the step and takes determinants; here eigenvalues are weighed."""
    found = scores_at_size(Base.of(fit), ASKED)
    for h in ASKED:
        small = [replace(h, effect=h.effect.as_large(float(size))) for size in SIZES_OF_PRIOR]
        told = [score(fit, [s])[0].evidence for s in small]
        best = int(np.argmax(told))
        assert found[h] == pytest.approx((told[best], SIZES_OF_PRIOR[best]), rel=1e-6)
        assert found[h][0] >= score(fit, [h])[0].evidence


def test_the_size_is_what_the_numbers_are(fit):
    _, size = scores_at_size(Base.of(fit), ASKED)[ASKED[0]]
    (std,) = {p.std for p in ASKED[0].effect.parameters}
    assert 0.002 < size * std < 0.01


def test_only_laws_that_are_straight_in_their_numbers_are_asked(fit):
    names = {h.effect.name for h in candidates(fit.model) if nearly_straight(h)}
    assert {"gyro_misalignment", "g_sensitivity", "accel_scale"} <= names
    assert not names & {"soft_mount", "low_pass", "vibration", "mount_shift"}


@pytest.mark.long
@pytest.mark.parametrize(
    ("effect", "numbers", "equal"),
    [
        ("gyro_scale", {"scale": [0.01, 0.01, 0.01]}, {("gyro_scale", "imu2")}),
        ("bias_jump", {"channel": "gyro", "jump": [0.02, 0.02, -0.02], "time": 3.0}, set()),
    ],
)
def test_what_has_no_name_is_equalled_by_the_names_that_explain_as_much(effect, numbers, equal, tmp_path):
    make_case(tmp_path / "r", "hinge", [(effect, "imu2", numbers)], 8, seconds=6.0, rate=50.0)
    fit = nominal_fit(read(tmp_path / "r")[0])
    best = fitted_term(fit, promising(fit)[0][0], 0.0)
    assert best.term.at == "imu2"
    told = Unknowns((finding(best),), best.fit, ())
    (said,) = with_equals(told).findings
    assert {(e.effect, e.at) for e in said.equivalent} == equal
    assert replace(said, equivalent=()) == told.findings[0]
