"""The table of what findings move, and of what estimators make of it."""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.evidence import Estimated
from imubench.diagnosis.report import page
from imubench.diagnosis.result import Move
from tests.diagnosis.report.diagnoses import Balanced, simulated


def test_the_page_says_what_all_findings_move_together():
    moves = {"joint_axis": Move([7.9, 3.6], "deg")}
    several, shown = simulated(moves=moves)
    one = replace(several, findings=several.findings[:1])
    text = "<th class='number'>all together</th>"
    html = page(several, shown)
    assert text in html and "<td class='number'>7.60, 3.60</td><td class='number'>7.90, 3.60</td>" in html
    assert text not in page(one, shown)  # it stands beside the one finding


def test_the_page_says_what_estimators_make_of_it():
    d, shown = simulated()
    axis = Estimated(
        "olsson2020", "joint_axis", "deg", ("imu1", "imu2"), np.array([8.0, 3.9]), (np.array([7.9, 3.8]), None),
        (np.array([8.5, 4.6]), np.array([0.87, 1.01])), ("not identifiable", "converged"),
    )  # fmt: skip
    centre = Estimated("hinge-position", "joint_vector", "mm", ("imu1", "imu2"), np.array([12.0, 3.0]), (None, None))
    html = page(d, replace(shown, estimates=(axis, centre)))
    first = html[: html.index("</dl>")]
    for words in (
        "<td class=''>joint axis of imu1 and imu2, by olsson2020 (deg)</td><td class='number'>7.90, 3.80</td>"
        "<td class='number'>8.00, 3.90</td>",
        "joint centre of imu1 and imu2, by hinge-position (mm)</td><td class='number'>–</td>"
        "<td class='number'>12.0, 3.0</td>",
        "the joint axis by olsson2020 is off by <b>8.50 → 0.87</b> deg at imu1 and <b>4.60 → 1.01</b> deg at imu2",
        "olsson2020 calls its answer not identifiable on the recording as it came, converged without what was found.",
    ):
        assert words in first, words
    assert "hinge-position calls" not in first
    assert Balanced(html).wrong == []
