"""What the first screen of the page says and offers."""

from dataclasses import replace

import numpy as np

from imubench.diagnosis.evidence import Estimated
from imubench.diagnosis.report import Paths, page
from imubench.diagnosis.report.first_screen import command_lines
from imubench.diagnosis.report.headline import headline
from imubench.diagnosis.result import Doubt
from tests.diagnosis.report.diagnoses import simulated


def test_the_first_screen_answers_the_seven_questions():
    d, shown = simulated()
    html = page(d, shown, Paths("my rec", "out"))
    assert (
        "The simulation leaves out a soft mount that imu2 moves on as on springs. As declared, MuJoCo&#x27;s "
        "simulation is off by 0.85 m/s² RMS at the imu2 accelerometer x; with that in it, by 0.014 m/s². "
        "With that in it, only sensor noise is left." in html
    )  # an amplitude of 1.2 is 0.85 RMS; the bias, which is immaterial, is no part of it
    first = html[: html.index("</dl>")]
    for words in (
        "samples that the numbers were not learned from",
        "97 % of what noise does not explain is at imu2",
        "a soft mount that imu2 moves on as on springs: without it 96 % of the difference <abbr",
        "very likely, 98 %. This recording cannot tell it from a mount that imu2 rocks on.",
        "<td class=''>joint axis of imu1 and imu2 (deg)</td><td class='number'>7.60, 3.60</td>",
        "<td class=''>hinge angle (deg RMS)</td><td class='number'>0.90</td>",
        "the hinge angle is off by 2.92 → 0.46 deg RMS",
        "record 20 s of on-axis spin at 2 rad/s.",
        "imubench estimate olsson2020 &#x27;my rec&#x27; --with out",
        "imubench run out/model",
        "rerun out/diagnosis.rrd",
        "Immaterial</abbr>: a constant offset of imu1&#x27;s gyroscope",
    ):
        assert words in first, words
    assert "Bayes factor" not in first
    assert " nat" not in first


def test_the_command_to_copy_asks_the_estimator_whose_answers_are_shown():
    d, shown = simulated()
    paths = Paths("rec", "out")
    assert command_lines(d, shown, paths)[0] == "imubench estimate olsson2020 rec --with out"
    other = Estimated("seel2012", "joint_axis", "deg", ("imu1", "imu2"), np.array([8.0, 3.9]), (None, None))
    assert command_lines(d, replace(shown, estimates=(other,)), paths)[0].split()[2] == "seel2012"


def test_a_model_that_is_doubted_is_not_offered_for_correction():
    d, shown = simulated(
        doubts=(Doubt("prediction", "the declared model predicts better"),), verdict="partly explained"
    )
    html = page(d, shown)
    assert "--with" not in html
    assert "Do not correct with it" in html
    assert "no model was found that can be trusted" in headline(d)
