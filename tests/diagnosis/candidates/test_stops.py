"""A stop is told from knocks anywhere by the hinge angle at which the knocks begin."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.candidates import begin as begin_module
from imubench.diagnosis.candidates import end_stop as stops_module
from imubench.diagnosis.candidates.begin import begin as begun
from imubench.diagnosis.candidates.end_stop import Stop, settled_between, stop_of
from imubench.diagnosis.config.candidates import END_STOP
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.search.confidence import DOUBTFUL
from imubench.format1 import read
from imubench.proof.case import make_case


def looked_at(tmp_path, effect, seed):
    truth = make_case(tmp_path / "r", "hinge", [effect], seed, seconds=20.0, base="fixed", swing=True)
    recording = read(tmp_path / "r")[0]
    samples = check_samples(recording)
    known = samples.heard(recording)
    return truth["effects"][0]["parameters"], known, samples, nominal_fit(known, samples.masks)


@pytest.mark.parametrize("seed", [201, pytest.param(202, marks=pytest.mark.long)])
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


@pytest.mark.long
@pytest.mark.parametrize("seed", [203, pytest.param(213, marks=pytest.mark.slow)])
def test_a_pendulum_stops_about_the_axis_on_which_its_knocks_agree(seed, tmp_path):
    """The fit does not know where the world's y points: the stop is the same about the opposite axis."""
    truth = make_case(tmp_path / "r", "pendulum", [("end_stop", "joint")], seed, seconds=15.0, swing=True)
    begin = begun(read(tmp_path / "r")[0])
    (said,) = [f for f in begin.samples.findings if f.effect == "end_stop"]
    assert not begin.samples.unless_stopped
    angle = said.parameters["angle"]
    assert abs(angle.value - abs(truth["effects"][0]["parameters"]["angle"])) < min(2 * angle.std, 0.05)
    assert angle.std < 0.035


@pytest.mark.long
def test_knocks_of_a_pendulum_at_any_angle_are_no_stop(tmp_path):
    knocks = ("impacts", "imu1", {"times": [2.1, 3.4, 5.2, 6.9, 8.3, 9.6], "peak": 40.0})
    make_case(tmp_path / "r", "pendulum", [knocks], 204, seconds=15.0, swing=True)
    begin = begun(read(tmp_path / "r")[0])
    assert [f.effect for f in begin.samples.findings + begin.samples.unless_stopped] == ["impacts"]


@pytest.mark.parametrize(("swing", "stops"), [(1.6, True), (0.3, False)])
def test_how_closely_knocks_must_agree_goes_with_how_far_the_joint_swings(swing, stops, tmp_path, monkeypatch):
    """Of eight knocks on a pendulum that swung by 0.3 rad most lay within 0.016 rad about some axis."""
    _, _, samples, fit = looked_at(tmp_path, ("end_stop", "joint"), 201)
    count = sum(f.parameters["times"].value.size for f in samples.unless_stopped)

    def angle(_, time, heading=0.0):
        if len(time) == count:
            return swing / 2 + np.resize([0.012, -0.012], count)
        return swing / 2 * np.sin(2 * np.pi * time)

    monkeypatch.setattr(stops_module, "angle_at", angle)
    assert (stop_of(fit, samples) is not None) == stops


@pytest.mark.parametrize(("angle", "stops"), [(0.10, True), (0.036, False)])
def test_a_limb_does_not_pass_its_stop_by_much_of_its_swing(angle, stops, tmp_path, monkeypatch):
    """About an axis that a pendulum hardly swings about all its angles agree."""
    _, _, samples, fit = looked_at(tmp_path, ("end_stop", "joint"), 201)
    count = sum(f.parameters["times"].value.size for f in samples.unless_stopped)

    def swung(_, time, heading=0.0):
        return np.full(count, angle) if len(time) == count else 0.11 * np.sin(2 * np.pi * time)

    monkeypatch.setattr(stops_module, "angle_at", swung)
    assert (stop_of(fit, samples) is not None) == stops


@pytest.mark.long
def test_an_angle_that_is_another_without_the_knocks_is_no_stop(tmp_path, monkeypatch):
    """Of eight knocks on a sensor most agreed about some axis, at an angle known within 0.15 rad."""
    make_case(tmp_path / "r", "pendulum", [("end_stop", "joint")], 203, seconds=15.0, swing=True)
    between = begin_module.settled_between
    monkeypatch.setattr(
        begin_module, "settled_between", lambda *both: replace(between(*both), std=2 * END_STOP.unsettled_rad)
    )
    begin = begun(read(tmp_path / "r")[0])
    assert [f.effect for f in begin.samples.unless_stopped] == ["impacts"]
    assert begin.fit is begin.first


@pytest.mark.parametrize(("effect", "struck"), [("end_stop", True), ("impacts", False)])
def test_where_the_gyroscope_jumps_the_segment_was_struck(effect, struck, tmp_path):
    """Of few knocks no axis is sure: a stop's are told from a sensor's by what turns with them."""
    at = "joint" if effect == "end_stop" else "imu1"
    make_case(tmp_path / "r", "pendulum", [(effect, at)], 203, seconds=20.0, swing=True)
    samples = check_samples(read(tmp_path / "r")[0])
    said = [f for f in (*samples.findings, *samples.unless_stopped) if f.effect == "impacts"]
    assert [f.confidence <= DOUBTFUL for f in said] == [struck]
