"""Where no samples are, splines go on as smoothly as between them."""

from dataclasses import dataclass

import numpy as np
import pytest

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.bspline import SUPPORT, Knots, Moment, Tracks
from imubench.diagnosis.problem.motion_prior import quadrature
from imubench.diagnosis.problem.rig_kinematics import FORCE
from imubench.format1 import read
from imubench.jets import Jet
from imubench.proof.case import make_case

KNOTS = Knots(-0.1, 0.02, 40)


TRACKS = Tracks(KNOTS, {FORCE: 1})


@dataclass(frozen=True)
class Sampled:
    """As much of a model as says where samples are."""

    stamps: dict[str, np.ndarray]
    tracks: Tracks = TRACKS
    start: float = 3.0


def matrix(time):
    """The second derivatives (n, count) at times (n,) of splines, by coefficient."""
    first, weights = KNOTS.weights(time, 2)
    out = np.zeros((time.size, KNOTS.count))
    for row, (at, weight) in enumerate(zip(first, weights, strict=True)):
        out[row, at : at + SUPPORT] = weight
    return out


def test_intervals_beyond_the_samples_have_two_points_and_all_have_their_length():
    time, weights = quadrature(Sampled({"imu1.gyro": 3.0 + np.array([0.005, 0.495])}))
    assert np.all(np.diff(time) > 0)
    assert weights.sum() == KNOTS.count - 5
    assert np.all(weights[(time > 0.02) & (time < 0.48)] == 1.0)
    assert np.all(weights[(time < 0.02) | (time > 0.48)] == 0.5)
    assert np.all(np.isin(weights, (0.5, 1.0)))


def test_only_straight_lines_cost_nothing_where_no_samples_are():
    time, _ = quadrature(Sampled({"imu1.gyro": np.array([103.0, 104.0])}))
    middles = KNOTS.start + KNOTS.step * (np.arange(KNOTS.count - 5) + 0.5)
    free = [KNOTS.count - np.linalg.matrix_rank(matrix(at), tol=1e-6 * KNOTS.step**-2) for at in (time, middles)]
    assert free == [2, 5]


@pytest.mark.parametrize("seed", [5, 7])
def test_the_force_of_a_fit_does_not_run_away_at_its_ends(seed, tmp_path):
    """What runs away before the first sample sets the springs of a replay ringing."""
    make_case(tmp_path / "r", "hinge", [("rocking_mount", "imu2")], seed, "strong", seconds=4.0, rate=50.0)
    recording = read(tmp_path / "r")[0]
    fit = nominal_fit(recording)
    knots = fit.model.tracks.knots
    time = np.linspace(knots.start, knots.start + knots.step * (knots.count - 5), 2_000)
    force = Moment(fit.model.tracks, fit.state.coefficients, Jet(time[:, None])).track(FORCE).value
    most = max(np.abs(imu.accel).max() for imu in recording.imus)
    assert np.abs(force).max() < 1.5 * most  # the joint is not where the sensors are
