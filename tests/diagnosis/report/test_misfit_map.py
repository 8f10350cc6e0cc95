"""The map of where residuals exceed the noise."""

import numpy as np

from imubench.diagnosis.config.report import CHART
from imubench.diagnosis.report.misfit_map import misfit_map, of_traces, over_time
from tests.diagnosis.report.diagnoses import Balanced
from tests.diagnosis.test_diagnosis_result import WHERE, evidence


def test_the_map_is_dark_where_residuals_are_large_and_frames_it():
    shown = evidence()
    series = of_traces(shown.traces)
    _, levels = over_time(series, [s.before for s in series], shown.span)
    row = [f"{s.at}.{s.channel}" for s in series].index("imu2.acc_x")
    loud = np.flatnonzero(levels[row] > CHART.levels[1])
    times = shown.span[0] + (loud + 0.5) * (shown.span[1] - shown.span[0]) / levels.shape[1]
    assert loud.size and times.min() > 12 and times.max() < 19.3  # the mount rings from 12.4 to 18.9 s
    assert np.all(levels[: row - 3] < CHART.levels[0] * 1.3)  # the first sensor is at its noise
    drawn = misfit_map(shown, (WHERE,))
    assert drawn.count("class='frame'") == 2  # a window and a band
    assert drawn.count("<svg") == 4
    assert misfit_map(shown, (WHERE,), found=False).count("<svg") == 2
    assert Balanced(drawn).wrong == []
