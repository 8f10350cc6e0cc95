"""The rig that MuJoCo plays of what a recording declares."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.correction.found_rig import possible_moments, rig_of
from imubench.diagnosis.simulation.step import note_of_body
from imubench.format1 import read
from imubench.proof.case import make_case


def test_moments_that_a_body_can_have_stay():
    assert possible_moments(np.array([0.01, 0.02, 0.025])).tolist() == [0.01, 0.02, 0.025]


@pytest.mark.parametrize("order", [[0, 1, 2], [1, 2, 0], [2, 1, 0]])
def test_the_greatest_moment_stays_and_both_others_make_up_for_it(order):
    told = np.array([0.001, 0.0345, 0.0357])[order]
    found = possible_moments(told)
    assert found.max() == told.max()
    assert np.sort(found)[:2] - np.sort(told)[:2] == pytest.approx([0.0001, 0.0001])
    assert np.sort(found)[:2].sum() == pytest.approx(told.max())


def test_a_declared_body_whose_moments_are_just_impossible_swings_as_declared(tmp_path):
    make_case(tmp_path / "r", "hinge", [], 3, seconds=4.0, base="fixed", swing=True)
    recording = read(tmp_path / "r")[0]
    body = replace(recording.body, inertia=np.array([0.00095, 0.03566, 0.03456]))
    segment = rig_of(replace(recording, body=body), {}).segments[-1]
    assert (segment.mass, *segment.com) == (body.mass, *body.com)
    assert segment.inertia[1] == body.inertia[1]
    (note,) = note_of_body(replace(recording, body=body))
    assert note == (
        "No body has the declared moments of inertia 0.00095, 0.03566, 0.03456 kg m^2: "
        "the simulation has 0.001025, 0.03566, 0.03463."
    )
    assert note_of_body(recording) == note_of_body(replace(recording, body=None)) == ()
