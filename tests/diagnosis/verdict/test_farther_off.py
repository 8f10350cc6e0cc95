"""How uncertain what a user asks for is, held against the truth, and what a shift counts for beside it."""

import numpy as np
import pytest

from imubench import rotations
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.result import TOLERANCE, Move, is_material
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.verdict.estimate_shift import estimates_of, farther_off, spread_of, times
from imubench.format1 import read
from imubench.proof.case import make_case

SHORT = {"seconds": 8.0, "rate": 50.0, "band": 1.9, "vigour": 1.5}
SEEDS = (1, 2, 3, 4, 5, 6)


def test_axes_are_off_by_as_much_as_is_said(tmp_path):
    """By the true mounts, RMS over six recordings of two axes with two components each: 24 numbers, to 1 / sqrt(48).

    Four such deviations are within a factor of 1.6.
    """
    off, said = [], []
    for seed in SEEDS:
        truth = make_case(tmp_path / str(seed), "hinge", seed=seed, **SHORT)
        recording = read(tmp_path / str(seed))[0]
        fit = nominal_fit(recording, check_samples(recording).masks)
        axes = [np.mean(axis, axis=0) for axis in estimates_of(fit, times(fit)).axes]
        true = [rotations.rotate_back(np.array(m["quaternion"]), [0.0, 1.0, 0.0]) for m in truth["mounts"]]
        off += [float(rotations.angle_between(a, b)) ** 2 for a, b in zip(axes, true, strict=True)]
        said += list(np.radians(spread_of(fit)["joint_axis"]) ** 2)
    assert 1 / 1.6 < np.sqrt(np.mean(off) / np.mean(said)) < 1.6


@pytest.mark.parametrize(
    ("std", "worse"),
    [
        (0.0, 0.8),  # an exact answer is off by the shift
        (0.6, 0.4),  # sqrt(0.6^2 + 0.8^2) - 0.6
        (60.0, 0.8**2 / 120),  # chance moves it farther: d^2 / (2 s)
    ],
)
def test_a_shift_counts_for_what_it_adds_to_chance(std, worse):
    known = farther_off({"orientation": Move(np.array([0.0, 0.8]), "deg RMS")}, {"orientation": np.full(2, std)})
    assert known["orientation"].value == pytest.approx([0.0, worse], rel=1e-3)
    assert is_material(known, TOLERANCE) is (worse >= TOLERANCE[0])


def test_where_no_spread_is_known_a_shift_counts_whole():
    shift = Move(np.array(0.7), "deg RMS")
    assert farther_off({"hinge_angle": shift}, {})["hinge_angle"].value == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("shift", "without", "worse"),
    [
        (1.0, 0.0, 0.0),  # all of the answer's chance is that of the finding's numbers: a shift of one sigma is nothing
        (3.0, 0.0, np.sqrt(8.0) - 1),  # sqrt(9 - 1) - 1: what is left of three sigmas
        (1.0, 2.0, np.sqrt(2.0) - 1),  # no worse known than with more numbers
    ],
)
def test_a_shift_by_the_chance_of_the_findings_own_numbers_does_not_count(shift, without, worse):
    known = farther_off({"hinge_angle": Move(np.array(shift), "deg RMS")}, {"hinge_angle": np.array(1.0)},
                        {"hinge_angle": np.array(without)})  # fmt: skip
    assert known["hinge_angle"].value == pytest.approx(worse)
