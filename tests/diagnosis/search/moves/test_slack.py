"""Backlash that the clocks beside an encoder are taken for, and clocks that are late."""

import numpy as np
import pytest

from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.search.moves.swap_clock_for_backlash import ClocksToBacklash
from imubench.format1 import read
from imubench.proof.case import make_case
from tests.searching import moved

QUICK = {"encoder": True, "seconds": 10.0, "band": 6.83, "vigour": 0.9, "declare_noise": False}


def held(folder, effect, at, parameters):
    """Return the names of a recording's nominal fit, and of what is in their place."""
    make_case(folder / "r", "hinge", [(effect, at, parameters)], 20261126, **QUICK)
    fit = nominal_fit(read(folder / "r")[0])
    after = moved(ClocksToBacklash(), fit, [Kept.unjudged(h) for h in fit.model.hypotheses])
    return [h.name for h in fit.model.hypotheses], {k.hypothesis.name: k for k in after.kept}, after.fit


@pytest.mark.slow
def test_an_encoder_with_play_is_not_two_late_clocks(tmp_path):
    before, kept, fit = held(tmp_path, "backlash", "joint", {"range": 0.04})
    assert before == ["time_offset@imu1", "time_offset@imu2"]
    assert list(kept) == ["backlash@joint"]
    assert np.exp(fit.state.values["backlash@joint.range"]) == pytest.approx([0.04], rel=0.05)


@pytest.mark.long
def test_a_late_clock_is_no_backlash(tmp_path):
    before, kept, _ = held(tmp_path, "time_offset", "imu2", {"offset": 0.05})
    assert before
    assert list(kept) == before
