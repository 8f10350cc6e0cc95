"""Figures of what both models read beside the sensors: what they show and what they say."""

import re
from dataclasses import replace

import numpy as np

from imubench.diagnosis.report import page
from imubench.diagnosis.report.compared import figures, loudest, slow
from imubench.diagnosis.result import Finding, Interval, Simulation
from tests.diagnosis.report.diagnoses import Balanced, channel, simulated
from tests.diagnosis.test_diagnosis_result import TIME, diagnosis


def test_a_figure_shows_what_matters_most_and_says_what_it_finds():
    one = diagnosis().findings[0]
    drawn = figures(one, (channel("imu2.acc_x", 1.2, 0.02, held=((30.0, 60.0),)),), 0.0, None)
    assert "is off by 0.85 m/s² RMS, with it by 0.014 (noise 0.030)" in drawn
    assert drawn.count("<svg") == 2  # the signals and, beneath, the errors
    assert "s from the recording&#x27;s start, where it matters most; the numbers above are over all 60 s." in drawn
    assert Balanced(drawn).wrong == []
    assert figures(one, (), 0.0, None) == ""


def test_the_channels_that_a_finding_improves_most_are_drawn():
    some = (channel("imu1.acc_z", 0.1, 0.1), channel("imu2.acc_x", 1.2, 0.02), channel("imu2.acc_y", 0.4, 0.02))
    drawn = figures(diagnosis().findings[0], some, 0.0, None)
    assert "imu2 accelerometer x" in drawn and "imu2 accelerometer y" in drawn
    assert "imu1 accelerometer z" not in drawn


def test_a_finding_whose_place_something_else_takes_says_so_instead_of_two_like_curves():
    same = channel("imu2.gyr_y", 0.05, 0.05)
    drawn = figures(diagnosis().findings[0], (same,), 0.0, None)
    assert "<svg" not in drawn and "Without it the simulation follows the sensors as well" in drawn
    d, shown = simulated()
    d = replace(d, findings=(replace(d.findings[0], share=0.0), d.findings[1]))
    assert "without it under 1 % of the difference comes back" in page(d, replace(shown, comparisons=((same,), ())))


def test_a_torque_is_shown_over_the_whole_swing_that_was_rolled_out():
    friction = Finding("dry_friction", "joint", 0.9, {}, Interval(1.0, (0.5, 2.0)))
    one = (channel("encoder.hinge", 0.7, 0.001, "rad", 0.0005, ((30.0, 60.0),)),)
    rolled = Simulation("rolled out", ((0.0, 60.0),), True, {})
    assert "where it matters most" not in figures(friction, one, 0.0, rolled)
    assert "where it matters most" in figures(friction, one, 0.0, replace(rolled, how="prescribed"))
    assert "class='held' x='500'" in figures(friction, one, 0.0, rolled)  # the second half


def test_what_is_slow_is_shown_whole_and_what_is_quick_where_it_is_loud():
    loud = np.exp(-0.5 * ((TIME - 20) / 1.0) ** 2) * np.sin(2 * np.pi * 8 * TIME)
    some = loudest(TIME, loud)
    assert TIME[some][0] < 20 < TIME[some][-1]
    assert TIME[some][-1] - TIME[some][0] < 3.1  # s, the excerpt
    assert slow(TIME, 0.01 * TIME) and not slow(TIME, loud)
    assert loudest(TIME, 0.01 * TIME) == slice(0, len(TIME))


def test_figures_count_seconds_from_the_start():
    one = channel("imu2.acc_x", 1.2, 0.02)
    late = replace(one, time=one.time + 1000.0, held_out=((1010.0, 1020.0),))
    wave = np.where(np.abs(TIME - 15) < 2, 1.0, 0.1) * (one.before - one.measured)
    late = replace(late, before=late.measured + wave)
    drawn = figures(diagnosis().findings[0], (late,), 1000.0, None)
    shown = re.search(r"Shown: ([\d.]+) to ([\d.]+) s", drawn)
    assert shown is not None
    assert 13.0 <= float(shown[1]) <= 15.0  # s: the loud four seconds are 13 to 17
    assert "1013" not in drawn


def test_a_figure_that_is_held_out_throughout_says_so_and_is_not_shaded():
    one = diagnosis().findings[0]
    drawn = figures(one, (channel("imu2.acc_x", 1.2, 0.02, held=((0.0, 30.0), (30.0, 60.0))),), 0.0, None)
    assert "class='held'" not in drawn
    assert "All of it was simulated with numbers that were learned on other samples." in drawn
