"""Curves, ticks and panels of a chart."""

import re

import numpy as np
import pytest

from imubench.diagnosis.config.report import CHART
from imubench.diagnosis.report.chart import Line, Panel, panel, path, thinned, ticks
from tests.diagnosis.report.diagnoses import Balanced


@pytest.mark.parametrize("n", [50, 3000, 200_000])
def test_a_thinned_curve_keeps_every_extreme(n):
    rng = np.random.default_rng(n)
    x, y = np.linspace(0, CHART.width, n), rng.normal(size=n)
    a, b = thinned(x, y)
    assert len(a) <= max(n, 0) and len(a) <= 2 * CHART.width + 2
    assert (b.min(), b.max()) == (y.min(), y.max())
    assert np.all(np.diff(a) >= 0)
    if n > 2 * CHART.width:
        columns = np.clip(x.astype(int), 0, CHART.width - 1)
        worst = [
            np.ptp(y[columns == c]) - np.ptp(b[np.clip(a.astype(int), 0, CHART.width - 1) == c]) for c in (0, 500, 999)
        ]
        np.testing.assert_array_equal(worst, 0.0)


def test_a_path_leads_through_its_points():
    x, y = np.array([0.0, 10.04, 20.0, 500.0]), np.array([1.0, -3.26, 7.0, 100.0])
    first, rest = path(x, y).removeprefix("M").split("l")
    steps = np.array([float(v) for v in rest.split()]).reshape(-1, 2)
    points = np.cumsum([[float(v) for v in first.split()], *steps], axis=0)
    np.testing.assert_allclose(points, np.stack([x, y], axis=1), atol=0.05 + 1e-9)  # rounded to a tenth
    assert path(np.zeros(0), np.zeros(0)) == path(np.zeros(1), np.zeros(1)) == ""


def test_no_line_is_drawn_across_a_gap():
    time = np.concatenate([np.arange(0, 100), np.arange(150, 250)]) / 10
    text = panel(Panel("a", [Line(time, np.sin(time), "left")], (0.0, 25.0), "s"))
    assert re.findall(r"class='line left' d='([^']*)'", text)[0].count("M") == 2


def test_ticks_are_round_and_inside():
    for low, high in ((0.0, 60.0), (-1.3e-4, 2.2e-4), (12.4, 18.9), (1e5, 3e6)):
        found = ticks(low, high, 5)
        assert 2 <= len(found) <= 7
        assert low - 1e-9 * abs(low) <= found[0] and found[-1] <= high * (1 + 1e-9)
    assert ticks(3.0, 3.0, 5) == [3.0]


@pytest.mark.parametrize("values", [np.zeros(0), np.zeros(1), np.full(5, 2.0), np.array([np.nan, 1.0, np.nan])])
def test_a_panel_of_next_to_nothing_is_drawn(values):
    time = np.arange(float(len(values)))
    text = panel(Panel("a", [Line(time, values, "left")], (0.0, 4.0), "s", band=0.0))
    assert Balanced(text).wrong == []
    assert "nan" not in text
