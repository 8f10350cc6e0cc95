"""The report and the terminal on diagnoses made by hand: what they say, what they draw, and that nobody breaks them."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from imubench.commands.work.diagnose import print_diagnosis
from imubench.diagnosis.config.report import CHART
from imubench.diagnosis.evidence import Comparison, Estimated
from imubench.diagnosis.report import Paths, page
from imubench.diagnosis.report.chart import Line, Panel, panel, path, thinned, ticks
from imubench.diagnosis.report.compared import figures, loudest, slow
from imubench.diagnosis.report.first_screen import command_lines
from imubench.diagnosis.report.headline import explained_percent, headline, usual_noise
from imubench.diagnosis.report.misfit_map import misfit_map, of_traces, over_time
from imubench.diagnosis.report.numbers import NOT_SHOWN, brief, rows, size
from imubench.diagnosis.report.shares import explained_share, with_shares
from imubench.diagnosis.result import (
    Directions,
    Doubt,
    Finding,
    Interval,
    Move,
    Noise,
    Nonsense,
    Parameter,
    SimulatedChannel,
    Simulation,
)
from imubench.glossary import TERMS
from imubench.terminal import Terminal
from tests.diagnosis.test_diagnosis_result import TIME, WHERE, diagnosis, evidence, finding

VOID = {"meta", "br", "img"}


class Balanced(HTMLParser):
    """Collects tags that are not closed, or closed twice, and every attribute that loads something."""

    def __init__(self, text):
        super().__init__()
        self.open, self.wrong, self.loads = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.loads += [v for k, v in attrs if k in ("src", "href", "data", "action")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)


def channel(name, before, after, unit="m/s^2", noise=0.03, held=()):
    """A comparison whose models are off by noise-free waves of these amplitudes."""
    wave = np.sin(2 * np.pi * 8 * TIME)
    measured = 3 * np.sin(2 * np.pi * 0.4 * TIME)
    return Comparison(name, unit, TIME, measured, measured + before * wave, measured + after * wave, noise, held)


def simulated(**changes):
    """A diagnosis and its evidence with MuJoCo's simulations: a soft mount, and a bias that is immaterial."""
    held = ((30.0, 60.0),)
    every = (channel("imu2.acc_x", 1.2, 0.02, held=held), channel("imu2.gyr_y", 0.04, 0.002, "rad/s", 0.005, held))
    bias = replace(
        finding("gyro_bias", 0.9, False),
        parameters={"bias": Parameter([0.001, 0.0, 0.002], [0.001] * 3, "rad/s")},
        moves={"orientation": Move([0.1, 0.2], "deg RMS")},
    )
    channels = {
        c.channel: SimulatedChannel(
            c.unit, *(float(np.sqrt(np.mean((y - c.measured) ** 2))) for y in (c.before, c.after)), c.noise
        )
        for c in every
    }
    parts = {
        "findings": (diagnosis().findings[0], bias),
        "simulation": Simulation("prescribed", ((0.0, 60.0),), True, channels),
    }
    shown = replace(evidence(), simulated=every, comparisons=((every[0],), ()))
    return with_shares(diagnosis(**(parts | changes)), shown), shown


def said(d, shown, capsys, paths=None):
    print_diagnosis(d, shown, Terminal(), paths)
    return capsys.readouterr().out


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


def test_the_page_is_one_file_whose_tags_close_and_that_loads_nothing():
    for d, shown in (simulated(), (diagnosis(), evidence())):
        html = page(d, shown)
        found = Balanced(html)
        assert (found.wrong, found.open, found.loads) == ([], [], [])
        assert "url(" not in html and "@import" not in html and "<script" not in html
        assert "prefers-color-scheme: dark" in html and "max-width: 640px" in html
        assert len(html) < 200_000  # bytes: a mail takes it


def test_names_from_strangers_are_escaped():
    evil = "<img src=x onerror=alert(1)>"
    d, shown = simulated(recording=evil, doubts=(Doubt(evil, evil),), verdict="partly explained")
    html = page(d, replace(shown, notes=(evil,)), Paths(evil, evil))
    assert "<img" not in html
    assert Balanced(html).wrong == []


def test_what_is_a_nat_and_a_misfit_stays_in_what_is_folded():
    d, shown = simulated()
    html = page(d, shown)
    unfolded = re.sub(r"<details>.*?</details>", "", html, flags=re.DOTALL)
    unfolded = re.sub(r"<style>.*?</style>|title='[^']*'", "", unfolded, flags=re.DOTALL)
    for word in (" nat", "knot", "Misfit", "Bayes"):
        assert word not in unfolded, word
    assert "Misfit" in html and "nat</abbr>" in html


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


def test_the_command_to_copy_asks_the_estimator_whose_answers_are_shown():
    d, shown = simulated()
    paths = Paths("rec", "out")
    assert command_lines(d, shown, paths)[0] == "imubench estimate olsson2020 rec --with out"
    other = Estimated("seel2012", "joint_axis", "deg", ("imu1", "imu2"), np.array([8.0, 3.9]), (None, None))
    assert command_lines(d, replace(shown, estimates=(other,)), paths)[0].split()[2] == "seel2012"


def test_a_finding_without_a_place_for_its_figure_says_what_it_moves():
    html = page(diagnosis(), replace(evidence(), comparisons=()))
    assert "It moves: joint axis 7.60 and 3.60 deg (imu1 and imu2), hinge angle 0.90 deg RMS." in html
    assert "<figcaption>" not in html  # no simulation, no comparison, nothing unknown: nothing to draw but the map


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


def test_shares_are_what_comes_back_without_a_finding():
    d, shown = simulated()
    n = TIME.size
    total = (1.2**2 - 0.02**2) / 0.03**2 * n / 2 + (0.04**2 - 0.002**2) / 0.005**2 * n / 2
    expected = (1.2**2 - 0.02**2) / 0.03**2 * n / 2 / total
    assert d.findings[0].share == pytest.approx(expected, rel=1e-3)  # the sampled sine's power is 1/2 to 1e-4
    assert d.findings[1].share is None  # it is not compared
    given = replace(d, findings=(replace(d.findings[0], share=0.5), d.findings[1]))
    assert with_shares(given, shown).findings[0].share == 0.5
    assert explained_share(()) is None
    assert explained_share(shown.simulated) == pytest.approx(0.9997, abs=2e-4)  # 1 - (0.02 / 1.2)^2 in the loudest


def test_findings_that_matter_come_first_by_their_share():
    d, shown = simulated()
    mount = replace(d.findings[0], share=0.1)
    pose = replace(d.findings[0], effect="mount_pose", share=0.8, parameters={})
    html = page(replace(d, findings=(d.findings[1], mount, pose)), replace(shown, comparisons=()))
    titles = (
        "</span>imu2 sitting elsewhere than the model has it ",
        "</span>A soft mount that imu2 moves on as on springs ",
        "<h2>Immaterial: below 0.5 deg and 5 mm",
    )
    places = [html.index(f"{title}<") for title in titles]
    assert places == sorted(places)


def test_noise_that_nobody_knows_is_never_only_noise():
    nobody = {"imu1.gyro": Noise(0.3, "rad/s", "unknown"), "imu2.accel": Noise(0.03, "m/s^2", "declared")}
    d, shown = simulated(noise=nobody, verdict="partly explained")
    html = page(d, shown)
    assert "only sensor noise is left" not in html.lower()
    assert "That explains 99 % of what differs." in headline(d)
    assert explained_percent(d) == "99 %"  # 99.97 % is not all
    usual = usual_noise(d, {"imu1": 100.0, "imu2": 100.0})
    assert usual == "imu1.gyro was taken to have 17.2 deg/s per sample, such IMUs usually have 0.097 to 0.35."
    # the profiles' least is the Awinda's 0.0017 rad/s, their most the MTw's 0.05 deg/s/sqrt(Hz) over 50 Hz
    assert "imu1.gyro was taken to have 17.2 deg/s" in html
    both = replace(d, noise=nobody | {"imu2.gyro": nobody["imu1.gyro"]})
    assert usual_noise(both, {"imu1": 100.0, "imu2": 100.0}).startswith(
        "imu1.gyro and imu2.gyro were taken to have 17.2"
    )
    quiet = diagnosis(noise=nobody, verdict="no mismatch", findings=(), where=())
    assert "How loud the sensors are is not known" in headline(quiet)
    assert "what differs is sensor noise" in headline(replace(quiet, noise={}))


def test_without_a_simulation_the_page_speaks_of_the_fit():
    d, shown = diagnosis(), evidence()
    html = page(d, shown)
    assert "With that in it, only sensor noise is left." in html
    assert "4.71 as declared, 1.01 with what was found" in html
    assert explained_percent(d) == "78 %"  # 1 - 1.01 / 4.71
    assert explained_percent(diagnosis(misfit=(0.97, 0.9))) == ""  # nothing differs beyond noise


def test_what_explains_but_leaves_more_than_noise_is_not_called_only_noise():
    d, _ = simulated()
    channels = {n: replace(c, after=3 * c.noise) for n, c in d.simulation.channels.items()}
    left = replace(d, simulation=replace(d.simulation, channels=channels))
    assert "only sensor noise" not in headline(left)
    assert "That explains 97 % of what differs." in headline(left)  # 1 - 2 * 3^2 / (28.3^2 + 5.66^2)


def test_a_simulation_that_follows_the_sensors_either_way_is_not_called_off():
    """A recovered motion may take in a clock's error; then what each finding changes is told instead."""
    d, shown = simulated()
    channels = {n: replace(c, before=0.9 * c.noise, after=c.noise) for n, c in d.simulation.channels.items()}
    same = replace(d, simulation=replace(d.simulation, channels=channels), misfit=(0.99, 1.0))
    assert "off by" not in headline(same) and "With that in it, only sensor noise is left." in headline(same)
    assert explained_percent(same) == ""
    html = page(same, shown)
    assert "the declared model follows the sensors as well" in html
    assert (
        "Without a soft mount that imu2 moves on as on springs the simulated imu2 accelerometer x is off by 0.85"
        in html
    )


def test_a_figure_that_is_held_out_throughout_says_so_and_is_not_shaded():
    one = diagnosis().findings[0]
    drawn = figures(one, (channel("imu2.acc_x", 1.2, 0.02, held=((0.0, 30.0), (30.0, 60.0))),), 0.0, None)
    assert "class='held'" not in drawn
    assert "All of it was simulated with numbers that were learned on other samples." in drawn


def test_something_unknown_is_drawn_and_nothing_is_not():
    unknown = Finding("unknown", "imu2", 0.8, {}, Interval(0.0, (0.0, 0.0)), where=WHERE)
    bare = replace(evidence(), comparisons=())
    html = page(diagnosis(verdict="unexplained", findings=(unknown,)), bare)
    assert "no effect of the library explains it" in html
    assert "m/s² RMS is left, where sensor noise leaves" in html
    assert "--with" not in html  # nothing can be taken out
    html = page(diagnosis(verdict="no mismatch", findings=(), where=()), bare)
    assert "Nowhere by more than the sensors&#x27; noise" in html
    assert "<figcaption>" not in html


def test_a_recording_that_makes_no_sense_is_told_so_and_what_to_look_at(capsys):
    wrong = Nonsense("imu2", "imu2 looks mirrored in z", {}, ("gyr_z",), "check the signs and the order of imu2's axes")
    unknown = Finding("unknown", "imu2", 0.9, {}, Interval(0.0, (0.0, 0.0)))
    d = diagnosis(verdict="unexplained", findings=(unknown,), where=(), nonsense=(wrong,))
    html = page(d, evidence())
    assert "imu2 looks mirrored in z. No simulation can be held against that." in html
    assert "<dt>What next?</dt><dd><p>To do: check the signs and the order of imu2&#x27;s axes.</p></dd>" in html
    assert "Because of what" not in html and "<svg" not in html and "model</code>" not in html
    text = said(d, evidence(), capsys)
    assert text.count("check the signs and the order of imu2's axes") == 1


def test_a_model_that_is_doubted_is_not_offered_for_correction():
    d, shown = simulated(
        doubts=(Doubt("prediction", "the declared model predicts better"),), verdict="partly explained"
    )
    html = page(d, shown)
    assert "--with" not in html
    assert "Do not correct with it" in html
    assert "no model was found that can be trusted" in headline(d)


def test_a_vector_is_told_as_a_whole_and_what_is_not_seen_is_no_number():
    covariance = np.diag([1e-6, 0.02, 1e-6])
    p = Parameter([0.003, 0.2, 0.004], np.sqrt(np.diag(covariance)), "m", Directions(covariance, np.eye(3)[:, [1]]))
    table = list(rows("translation", p))
    assert [r[1:3] for r in table][1] == ("", NOT_SHOWN)
    assert table[0][1:3] == ("3.0", "1.0 to 5.0")
    # |(3, 0, 4)| = 5 mm, its std 1 mm as every direction of these has it, and so 5 std from none
    assert size("translation", p) == (
        "The translation as a whole, in the directions that are seen, is 5.0 mm long (3.0 to 7.0, 95 %), "
        "5.0 standard deviations from none."
    )
    none = replace(p, fixed=None)
    assert size("translation", none) == "" and all(r[1] for r in rows("translation", none))
    nothing = replace(p, fixed=Directions(covariance, np.eye(3)))
    assert size("translation", nothing) == ""


def test_marginals_that_all_hold_zero_may_be_far_from_it_together():
    u = np.array([1.0, -1.0]) / np.sqrt(2)
    covariance = 0.04 * np.eye(2) - 0.039 * np.outer(u, u)  # known well along u alone
    p = Parameter([0.1, -0.1], np.sqrt(np.diag(covariance)), "m/s^2", Directions(covariance, np.zeros((2, 0))))
    assert all(r[2].startswith("−") or " to −" not in r[2] for r in rows("bias", p))
    away = 0.1 * np.sqrt(2) / np.sqrt(0.001)
    assert f"{away:.1f} standard deviations from none" in size("bias", p)


@pytest.mark.parametrize(("value", "text"), [(69.4335, "69.4"), (0.1702, "0.17"), (0.00249, "0.0025"), (0.0, "0"),
                                             (1234.5, "1234"), (1.0, "1.00")])  # fmt: skip
def test_sizes_have_the_digits_that_a_reader_needs(value, text):
    assert brief(value) == text


def test_the_terminal_says_the_same_and_what_to_type(capsys):
    d, shown = simulated()
    text = said(d, shown, capsys, Paths("rec", "out"))
    for words in (
        "explained: The simulation leaves out a soft mount that imu2 moves on as on springs.",
        "alarm: a soft mount that imu2 moves on as on springs may matter: joint axis 7.60 and 3.60 deg",
        "imu2 accelerometer x: 0.85 as declared, 0.014 with what was found (m/s²; noise 0.030)",
        "immaterial, below 0.5 deg and 5 mm:\n  gyro_bias at imu1 (90 % sure) moves orientation",
        "hinge angle 0.90 deg RMS. Without it 96 % of the difference comes back.",
        "imubench estimate olsson2020 rec --with out\n",
    ):
        assert words in text, words
    small = diagnosis(findings=d.findings[1:])
    text = said(small, shown, capsys)
    assert "no alarm: nothing that is sure moves a joint or a segment by 0.5 deg and 5 mm." in text
    assert "a constant offset of imu1's gyroscope, which moves nothing by 0.5 deg and 5 mm." in text


def test_every_word_that_the_page_explains_is_in_the_glossary():
    html = page(*simulated())
    told = set(re.findall(r"<abbr title='([^']*)'", html))
    assert len(told) >= 5
    every = {t.replace("'", "&#x27;") for t in TERMS.values()}
    assert told <= every
