"""Effects as small as they are: what they promise, and a faint one that was something without a name."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.by_size import could_be
from imubench.diagnosis.columns import Base
from imubench.diagnosis.hypothesis import Hypothesis
from imubench.diagnosis.nominal import nominal_fit
from imubench.diagnosis.own_size import SIZES, sized
from imubench.diagnosis.score import score
from imubench.diagnosis.select import candidates
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


def test_what_effects_promise_is_what_the_search_says_of_priors_of_every_size(fit):
    """The search solves for the step and takes determinants; here eigenvalues are weighed."""
    found = sized(Base.of(fit), ASKED)
    for h in ASKED:
        small = [replace(h, effect=h.effect.as_large(float(size))) for size in SIZES]
        told = [score(fit, [s])[0].evidence for s in small]
        best = int(np.argmax(told))
        assert found[h] == pytest.approx((told[best], SIZES[best]), rel=1e-6)
        assert found[h][0] >= score(fit, [h])[0].evidence


def test_the_size_is_what_the_numbers_are(fit):
    _, size = sized(Base.of(fit), ASKED)[ASKED[0]]
    (std,) = {p.std for p in ASKED[0].effect.parameters}
    assert 0.002 < size * std < 0.01


def test_only_laws_at_the_term_s_imu_that_are_straight_in_their_numbers_are_asked(fit):
    term = Hypothesis(EFFECTS["gyro_bias"], "imu1")
    asked = [h for h in candidates(fit.model) if could_be(h, term)]
    assert {h.at for h in asked} == {"imu1"}
    names = {h.effect.name for h in asked}
    assert {"gyro_misalignment", "g_sensitivity", "accel_scale"} <= names
    assert not names & {"soft_mount", "low_pass", "vibration", "mount_shift"}
