"""The sentence over a map says what the map shows."""

import numpy as np
import pytest

from imubench.sweeps.axis import parse_axis
from imubench.sweeps.cells import Map
from imubench.sweeps.drawing import figures, svg
from imubench.sweeps.finding import crossing, finding, headline
from imubench.sweeps.spec import Sweep

X = parse_axis(
    {"parameter": "rig.soft.frequency", "values": [5, 10, 20, 40], "scale": "log", "label": "stiffness"}, "x"
)
Y = parse_axis({"parameter": "rig.soft.damping_ratio", "values": [0.1, 0.4], "label": "damping ratio"}, "y")
OFFSETS = parse_axis({"parameter": "effect.time_offset.offset", "values": [-20, 0, 20, 40], "unit": "ms"}, "x")


def of(value, *axes, played=1.0, quantile=0.5):
    value = np.array(value, dtype=float)
    value = value[:, None] if value.ndim == 1 else value
    share = np.broadcast_to(np.asarray(played, dtype=float), value.shape)
    bound = np.where(share > 0.5, value, np.inf)
    low, high = value * 0.8, value * 1.2
    found = Map("mine", np.where(share > 0, value, np.nan), bound, low, high, share, np.isinf(value) * 1.0, False)
    sweep = Sweep("s", "", axes or (X,), 20, None, quantile, 2.0, "deg", {})
    return sweep, found


def said(value, *axes, **more):
    return finding(*of(value, *axes, **more)).removeprefix("mine: the median of the error ")


def test_one_axis():
    assert said([8, 4, 1, 0.5]) == "stays below 2 deg from 14 Hz up"  # half way in both logarithms
    assert said([0.5, 1, 4, 8]) == "stays below 2 deg up to 14 Hz"
    assert said([1, 1, 1, 1]) == "stays below 2 deg in every cell"
    assert said([3, 3, 3, 3]) == "is below 2 deg in no cell"
    assert said([1, 3, 1, 3]) == "is below 2 deg in 2 of 4 cells"
    assert said([4, 1, 4, 8], OFFSETS) == "stays below 2 deg from -10 to 10 ms"


def test_nothing_is_interpolated_up_to_where_there_is_no_answer_or_no_recording():
    assert said([np.inf, 1, 1, 1]) == "stays below 2 deg from 10 Hz up"
    assert said([4, 1, 1, 1], played=[[0.2], [1], [1], [1]]) == "stays below 2 deg from 10 Hz up"


def test_two_axes():
    rows = np.array([[8, 4], [4, 1], [1, 1], [1, 1]])
    assert said(rows, X, Y) == (
        "stays below 2 deg from 7.1 Hz up at damping ratio 0.4, and from 14 Hz up at damping ratio 0.1"
    )
    assert said(np.array([[8, 8], [4, 3.9], [1, 1], [1, 1]]), X, Y) == (
        "stays below 2 deg from 14 Hz up, whatever the damping ratio"
    )
    assert said(np.array([[8, 4], [8, 1], [8, 1], [8, 1]]), X, Y) == (
        "stays below 2 deg from 7.1 Hz up at damping ratio 0.4, and nowhere at damping ratio 0.1"
    )
    assert said(np.array([[1, 4], [4, 1], [4, 1], [1, 1]]), X, Y) == "is below 2 deg in 5 of 8 cells"


def test_another_quantile_is_called_so():
    assert "the 90 % quantile of the error" in finding(*of([8, 4, 1, 1], quantile=0.9))


def test_the_headline_has_the_best_first():
    sweep, worse = of([8, 4, 1, 1])
    _, better = of([8, 1, 1, 1])
    better = Map("theirs", *(getattr(better, f) for f in ("value", "bound", "low", "high", "played", "failed")), False)
    assert headline(sweep, [worse, better]) == "Error below 2 deg: theirs in 3 of 4 cells, mine in 2"


def test_the_headline_of_one_is_what_its_map_shows():
    sweep, alone = of([8, 4, 1, 1])
    assert headline(sweep, [alone]) == finding(sweep, alone)


def test_a_crossing_is_where_the_straight_line_of_logarithms_has_it():
    assert crossing(X, (10.0, 1.0), (20.0, 4.0), 2.0) == pytest.approx(np.sqrt(200), rel=1e-12)  # rounding
    assert crossing(OFFSETS, (0.0, 1.0), (20.0, 4.0), 2.0) == pytest.approx(10.0, rel=1e-12)


@pytest.mark.parametrize("axes", ((X,), (X, Y), (OFFSETS,)))
def test_a_picture_is_the_same_every_time_and_has_the_page_s_ink(axes):
    value = [[8, 4], [np.inf, 1], [1, 1], [1, 1]] if len(axes) > 1 else [8, np.inf, 1, 1]
    played = [[0.5, 1], [1, 1], [1, 0], [1, 1]] if len(axes) > 1 else [[0.5], [1], [1], [0.0]]
    first, again = (svg(figures(*_listed(of(value, *axes, played=played)))[0], "mine") for _ in range(2))
    assert first == again
    assert "currentColor" in first
    assert axes[0].title in first


def _listed(both):
    sweep, found = both
    return sweep, [found]
