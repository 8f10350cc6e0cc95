"""What a pivot that moves as it likes explains of a lone IMU, and a filter beside a scale too."""

import pytest

from imubench.diagnosis.criteria.dynamic_score import Screened, lawless_score
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.add import next_plain
from imubench.diagnosis.search.moves.dynamic_refits import refit_from_screening
from imubench.diagnosis.search.moves.swap_states_for_law import states_to_law
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.schur import Base
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

FILTERED = [
    ("low_pass", "imu1", {"cutoff": 16.0, "channels": ["gyro"]}),
    ("accel_scale", "imu1", {"scale": [-0.01, 0.0, 0.015]}),
]
MOVED = [("moving_pivot", "joint")]


def trials_of(folder, effects):
    """The fit without effects; a moving pivot and a filter of the gyroscope beside it, each fitted alone."""
    make_case(folder, "pendulum", effects, 5, "strong", seconds=8.0, band=3.0)
    fit = nominal_fit(read(folder)[0])
    pivot = Hypothesis(EFFECTS["moving_pivot"], "joint")
    slow = next(h for h in candidates(fit.model) if h.name == "low_pass[gyro]@imu1")
    begun = Screened(slow, 0.0, {slow.key(p.name): p.start for p in slow.effect.parameters}, {})
    ways = [refit_from_screening(fit, [way], rounds=3) for way in (lawless_score(Base.of(fit), pivot), begun)]
    return fit, [h for h in candidates(fit.model) if not h.effect.states], ways


@pytest.mark.long
def test_a_filter_and_a_scale_stand_before_a_pivot_that_explains_less_than_both(tmp_path):
    fit, plain, (pivot, slow) = trials_of(tmp_path / "r", FILTERED)
    assert slow.evidence < pivot.evidence
    led = states_to_law(fit, fit, [pivot, slow], plain, lambda _: None, next_plain)
    assert [t.hypothesis.name for t in led][:2] == ["low_pass[gyro]@imu1", "accel_scale@imu1"]
    assert (
        states_to_law(fit, fit, [slow, pivot], plain, lambda _: None, next_plain) is None
    )  # that with a law is the first anyhow


@pytest.mark.long
def test_a_pivot_that_moves_keeps_its_place(tmp_path):
    fit, plain, (pivot, slow) = trials_of(tmp_path / "r", MOVED)
    assert states_to_law(fit, fit, [pivot, slow], plain, lambda _: None, next_plain) is None
