"""The segments of a fit's rig: one on the other, however many there are."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.diagnosis.problem.bspline import Moment, Tracks
from imubench.diagnosis.problem.hypothesis import State
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, HINGE
from imubench.diagnosis.solve.initialize import model_of
from imubench.jets import Jet
from imubench.models.tree import HINGE as A_HINGE
from imubench.models.tree import Joint, Tree, TreeSegment
from imubench.recording import Imu, Recording

TIME = np.linspace(0.0, 0.5, 20)


def model(rig: str, **changes: object):
    still = np.zeros((TIME.size, 3))
    imus = tuple(
        Imu(name, TIME, still, still + np.array([0, 0, 9.81]), 40.0)
        for name in ("imu1", "imu2")[: 2 if rig == "hinge" else 1]
    )
    return model_of(Recording("r", rig, imus, **changes), knots_per_s=20.0)


def motions(model, coefficients):
    state = State(coefficients, {name: prior.start for name, prior in model.priors.items()})
    return model.segments(state, Moment(model.tracks, coefficients, Jet(TIME[3:-3, None])))


def test_two_hinges_in_a_row_turn_as_one_by_both_angles():
    """A third segment between the two of a hinge: about one axis its angle and the last one's add up."""
    plain, rng = model("hinge"), np.random.default_rng(0)
    first, last = plain.rig.tree.segments
    middle = TreeSegment("middle", first.name, (Joint("knee", A_HINGE, (0.0, 1.0, 0.0)),), (), None)
    rig = replace(plain.rig, tree=Tree((first, middle, replace(last, parent="middle"))))
    assert rig.widths == plain.rig.widths | {"knee": 1}
    chain = replace(plain, rig=rig, tracks=Tracks(plain.tracks.knots, rig.widths))
    own = 0.3 * rng.standard_normal((chain.tracks.knots.count, chain.tracks.width))
    own[:, chain.tracks.columns(ATTITUDE)] += [1.0, 0.0, 0.0, 0.0]
    summed = np.concatenate([own[:, chain.tracks.columns(name)] for name in plain.tracks.widths], axis=1)
    summed[:, plain.tracks.columns(HINGE)] += own[:, chain.tracks.columns("knee")]
    three, two = motions(chain, own), motions(plain, summed)
    assert list(three) == ["segment1", "middle", "segment2"]
    for name in two:
        for part in ("rate", "accel", "force"):  # equal but for rounding
            assert_allclose(getattr(three[name], part).value, getattr(two[name], part).value, atol=1e-9)
        assert_allclose(three[name].turn.matrix, two[name].turn.matrix, atol=1e-12)
    assert np.abs(three["middle"].rate.value - three["segment1"].rate.value).max() > 0.1


@pytest.mark.parametrize(
    ("rig", "changes", "tracks"),
    [
        ("hinge", {}, {"attitude": 4, "force": 3, "velocity": 3, "hinge": 1}),
        ("hinge", {"base": "fixed"}, {"hinge": 1}),
        ("pendulum", {}, {"attitude": 4}),
        ("free", {}, {"attitude": 4, "force": 3, "velocity": 3}),
    ],
)
def test_a_rig_has_the_splines_that_its_tree_needs(rig, changes, tracks):
    found = model(rig, **changes)
    assert found.rig.widths == tracks
    assert list(found.rig.tree.names) == ["segment1", "segment2"][: len(found.rig.tree.names)]
