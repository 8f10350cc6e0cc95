"""The motion that a fit tells: what it says of a pivot that moves, beside the acceleration that the pivot has."""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.residual_checks.fit_summary import played
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.rotations import rotate


def test_the_force_at_a_pivot_is_its_own_acceleration_once(tmp_path):
    """At a pivot with acceleration a the specific force is a - g, in world axes; a cubic spline holds a constant."""
    make_case(tmp_path / "r", "pendulum", [], 5, seconds=3.0, rate=50.0)
    pivot = Hypothesis(EFFECTS["moving_pivot"], "joint")
    fit = extended(nominal_fit(read(tmp_path / "r")[0]), (pivot,))
    own = fit.model.tracks.columns(pivot.key("acceleration"))
    given = np.array([0.3, -0.2, 0.5])
    coefficients = fit.state.coefficients.copy()
    coefficients[:, own] = given
    told = played(replace(fit, state=State(coefficients, fit.state.values)))
    up = np.array([0.0, 0.0, fit.model.recording.gravity])
    force = rotate(told.quaternion1, told.force)  # from the segment's axes
    np.testing.assert_allclose(force - up, np.broadcast_to(given, force.shape), atol=1e-6)
