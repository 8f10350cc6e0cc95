"""A stop is told from knocks anywhere by the hinge angle at which the knocks begin."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.nominal import nominal_fit
from imubench.diagnosis.samples import sampled
from imubench.diagnosis.stops import Stop, settled_between, stop_of
from imubench.diagnosis.verdict import DOUBTFUL
from imubench.format1 import read
from imubench.proof.case import make_case


def looked_at(tmp_path, effect, seed):
    truth = make_case(tmp_path / "r", "hinge", [effect], seed, seconds=20.0, base="fixed", swing=True)
    recording = read(tmp_path / "r")[0]
    samples = sampled(recording)
    known = samples.heard(recording)
    return truth["effects"][0]["parameters"], known, samples, nominal_fit(known, samples.masks)


@pytest.mark.parametrize("seed", [201, 202])
def test_a_stop_is_where_the_knocks_begin(seed, tmp_path):
    true, known, samples, fit = looked_at(tmp_path, ("end_stop", "joint"), seed)
    stop = stop_of(fit, samples)
    assert stop is not None
    assert stop.angle == pytest.approx(true["angle"], abs=0.015)  # the fit's spline rounds a contact of milliseconds
    swings = stop.swings(known.free_swings)
    assert len(swings) > 1 and not any(a < t < b for a, b in swings for t in stop.knocks)
    without = nominal_fit(replace(known, free_swings=swings), stop.masks(fit, samples.masks))
    stop = settled_between(stop, without)
    assert abs(stop.angle - true["angle"]) < 3 * stop.std < 0.03
    said = stop.told(samples)
    assert [f.effect for f in said.findings] == ["end_stop"] and not said.unless_stopped


def test_knocks_at_any_angle_are_no_stop(tmp_path):
    _, _, samples, fit = looked_at(tmp_path, ("impacts", "imu2"), 204)
    assert samples.unless_stopped
    assert stop_of(fit, samples) is None


def test_contacts_are_cut_out_of_swings():
    stop = Stop(0.5, 0.01, np.array([2.0]), ((1.9, 2.2), (3.0, 5.0)))
    assert stop.swings(((1.0, 4.0), (4.5, 6.0))) == ((1.0, 1.9), (2.2, 3.0), (5.0, 6.0))


@pytest.mark.parametrize(("effect", "struck"), [("end_stop", True), ("impacts", False)])
def test_where_the_gyroscope_jumps_the_segment_was_struck(effect, struck, tmp_path):
    """A pendulum has no hinge angle to read a stop off; its knocks are told from a sensor's by what turns with them."""
    at = "joint" if effect == "end_stop" else "imu1"
    make_case(tmp_path / "r", "pendulum", [(effect, at)], 203, seconds=20.0, swing=True)
    samples = sampled(read(tmp_path / "r")[0])
    said = [f for f in (*samples.findings, *samples.unless_stopped) if f.effect == "impacts"]
    assert [f.confidence <= DOUBTFUL for f in said] == [struck]
