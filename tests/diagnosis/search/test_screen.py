"""Effects with states of their own are found by their laws, on an excerpt; hums where they are."""

import numpy as np
import pytest

from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.candidates.grids import hum_frequency, strongest_line
from imubench.diagnosis.criteria.conditional_aic import aic_gain_of, linear_tally, tally
from imubench.diagnosis.criteria.dynamic_score import Screened, screen
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.batch_model import started
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.admission import asked
from imubench.diagnosis.search.moves.add_dynamic import SHORT, state_trials
from imubench.diagnosis.search.moves.dynamic_order import LONE, promising, softer
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.solve.gauss_newton import all_rows
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.subset import cut, excerpt, loudest
from imubench.effects import EFFECTS, VARIANTS
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """Return a function that makes a case and fits the model as declared to it, each case once."""
    done = {}

    def make(*effects, seed=3, seconds=12.0, rig="hinge", **options):
        key = (effects, seed, seconds, rig)
        if key not in done:
            folder = tmp_path_factory.mktemp("case") / "r"
            truth = make_case(folder, rig, list(effects), seed, seconds=seconds, **options)
            recording = read(folder)[0]
            done[key] = (recording, nominal_fit(recording), truth)
        return done[key]

    return make


def lively(fit):
    return [h for h in candidates(fit.model) if h.effect.states and h.effect.variant != "isotropic"]


@pytest.mark.slow
@pytest.mark.parametrize(("effect", "at", "key"), [("soft_mount", "imu2", "frequency"), ("joint_play", "joint", None)])
def test_the_right_law_is_refitted_from_near_its_parameter(fitted, effect, at, key):
    _, fit, truth = fitted((effect, at))
    tried = promising(screen(fit, lively(fit)), 5.0, lone=False)[0]  # a filter looks like a stiff spring
    best = next(s for s in tried if (s.hypothesis.effect.name, s.hypothesis.at) == (effect, at))
    if key is not None:
        true = np.asarray(truth["effects"][0]["parameters"][key])
        seen = np.exp(best.values[best.hypothesis.key(key)])
        assert np.all(np.abs(np.log(seen / true)) < 0.45)  # the grid's points are 0.4 apart
        assert 0.1 < best.amount < 2.0  # 1 by the law; the fit's motion has taken most of a stiff spring in


@pytest.mark.long
def test_a_clean_recording_promises_no_state(fitted):
    _, fit, _ = fitted()
    assert screen(fit, lively(fit))[0].evidence < 0


@pytest.mark.slow
@pytest.mark.parametrize(("effect", "at", "seed"), [("soft_mount", "imu2", 22), ("rocking_mount", "imu1", 32)])
def test_a_spring_is_fitted_from_its_screening(fitted, effect, at, seed):
    _, fit, truth = fitted((effect, at), seed=seed, seconds=25.0)
    best = state_trials(fit, lively(fit), lambda _: None)[0]
    assert best.hypothesis.name == f"{effect}@{at}"
    true = truth["effects"][0]["parameters"]
    for key, tolerance in (("frequency", 0.08), ("damping_ratio", 1.2)):  # of the logarithm
        seen = np.exp(best.fit.state.values[best.hypothesis.key(key)])
        assert np.all(np.abs(np.log(seen / np.asarray(true[key]))) < tolerance), key


@pytest.mark.slow
@pytest.mark.parametrize("rig", ["free", "pendulum"])
def test_a_filter_on_the_only_sensor_is_found_whatever_its_screening_promises(tmp_path, rig):
    """The motion is known from what came out of it: of 2.4 Hz the screening says that it goes the wrong way."""
    slow = ("low_pass", "imu1", {"cutoff": 2.4, "channels": ["gyro", "accel"]})
    make_case(tmp_path / "r", rig, [slow], 3, seconds=12.0)
    fit = nominal_fit(read(tmp_path / "r")[0])
    assert next(s for s in screen(fit, lively(fit)) if s.hypothesis.name == "low_pass@imu1").amount < 0
    best = state_trials(fit, lively(fit), lambda _: None)[0]
    assert best.hypothesis.name == "low_pass@imu1"
    assert np.exp(best.fit.state.values["low_pass@imu1.cutoff"]) == pytest.approx(2.4, rel=0.03)


def promise_of(name, at, evidence, amount=1.0):
    effect = next(e for e in VARIANTS if (e.name, e.variant) == name)
    return Screened(Hypothesis(effect, at), evidence, {}, {}, amount)


def test_the_next_promises_are_tried_where_the_first_are_no_good():
    rocking, soft = promise_of(("rocking_mount", ""), "imu2", 960.0), promise_of(("soft_mount", ""), "imu2", 140.0)
    wrong_way, little = promise_of(("soft_mount", ""), "imu1", 500.0, -0.4), promise_of(("low_pass", ""), "imu2", 4.0)
    screened = [rocking, wrong_way, soft, little]
    assert promising(screened, 5.0, lone=False) == [[rocking], [soft]]
    single = [promise_of(("low_pass", part), "imu1", -10.0) for part in ("gyro", "accel", "")]
    first, then = promising([rocking, soft, *single], 5.0, lone=True)
    assert [s.hypothesis.effect.variant for s in first] == ["", "", "gyro"]
    assert (len(first), then) == (1 + LONE, [soft])


def test_variants_of_one_effect_count_as_one_that_is_tried():
    play = [promise_of(("joint_play", variant), "joint", nat) for variant, nat in (("springy", 900.0), ("", 800.0))]
    mounts = [promise_of((name, ""), at, 700.0) for name in ("rocking_mount", "soft_mount") for at in ("imu1", "imu2")]
    filters = [promise_of(("low_pass", part), "imu1", 600.0) for part in ("gyro", "accel", "")]
    assert promising([*play, *mounts], 5.0, lone=False)[0] == [*play, *mounts[:2]]
    assert promising([*play, *filters], 5.0, lone=False)[0] == [*play, *filters[:2]]


@pytest.mark.long
def test_play_about_one_axis_is_looked_at_in_eight_directions(tmp_path):
    """And not beside play about any axis, which has twice the states, where it promises nearly as much."""
    play = ("joint_play", "joint", {"range": 0.006, "direction": 2.0, "kind": "free"})
    make_case(tmp_path / "r", "hinge", [play], 5, seconds=12.0)
    fit = nominal_fit(read(tmp_path / "r")[0])
    found = [s for s in screen(fit, lively(fit)) if s.hypothesis.effect.name == "joint_play"]
    (freely,) = [s for s in found if s.hypothesis.effect.free]
    assert freely.hypothesis.effect.variant == ""
    off = (freely.values["joint_play@joint.direction"] - 2.0 + np.pi / 2) % np.pi - np.pi / 2
    assert abs(off) < np.pi / 8
    assert freely.evidence > 50.0


@pytest.mark.slow
def test_springs_are_tried_though_a_state_without_a_law_was_good_for_something(tmp_path):
    """102 nat were promised beside a moving pivot's 2,095; it comes to three times what the pivot does."""
    spring = {"frequency": [6.639, 7.903, 6.56], "damping_ratio": 0.2116}
    options = {"seconds": 12.0, "rate": 128.0, "band": 2.36, "vigour": 1.468, "misdeclared": -0.132}
    make_case(tmp_path / "r", "pendulum", [("soft_mount", "imu1", spring)], 397079575, **options)
    fit = nominal_fit(read(tmp_path / "r")[0])
    trials = state_trials(fit, lively(fit), lambda _: None)
    assert trials[0].hypothesis.name == "soft_mount@imu1"
    pivot = next(t for t in trials if t.hypothesis.name == "moving_pivot@joint")
    assert trials[0].evidence > 2 * pivot.evidence


@pytest.mark.slow
def test_a_spring_that_slow_motion_hardly_moves_promises_what_it_shows(tmp_path):
    """What of the fitted motion is noise made it ring, and so did a beginning without its sag: -25 nat."""
    spring = {"frequency": [11.54, 13.31, 13.87], "damping_ratio": 0.114}
    options = {"rate": 128.0, "rate2": 128.0, "encoder": True, "band": 1.725, "vigour": 0.874, "rest": 0.178}
    options |= {"gyro_noise": 0.0037, "accel_noise": 0.0382, "misdeclared": 0.0955, "rotation_std": 0.033}
    make_case(tmp_path / "r", "hinge", [("soft_mount", "imu1", spring)], 20261124, seconds=15.0, **options)
    fit = nominal_fit(read(tmp_path / "r")[0])
    found = [s for s in screen(fit, lively(fit)) if s.hypothesis.name == "soft_mount@imu1"]
    assert found[0].evidence > 50.0
    assert 0.4 < found[0].amount < 1.6  # 1 by the law


@pytest.mark.long
def test_an_excerpt_is_the_fit_of_its_samples(fitted):
    recording, fit, _ = fitted(("soft_mount", "imu2"))
    short = excerpt(fit, 3.0, 8.0)
    for rows in short.measured:
        whole = next(r for r in fit.measured if r.name == rows.name)
        same = (whole.time >= 3.0) & (whole.time <= 8.0)
        np.testing.assert_allclose(rows.whitened, whole.whitened[same], atol=1e-6)  # the same splines, sliced
    part = cut(recording, short.model.start + 3.0, short.model.start + 8.0)
    assert part.imus[0].time[0] >= short.model.start + 3.0
    start, end = loudest(fit, 4.0)
    assert end - start == pytest.approx(4.0)


@pytest.mark.long
def test_a_hum_is_heard(fitted):
    _, fit, truth = fitted(("vibration", "imu1"), seed=101)
    true = float(truth["effects"][0]["parameters"]["frequency"])
    assert strongest_line(fit, "imu1") == pytest.approx(true, abs=0.1)  # a line of 12 s is 0.08 Hz wide


@pytest.mark.long
def test_a_state_without_a_law_is_seen_in_what_the_fit_took_for_noise(fitted):
    _, fit, _ = fitted(("moving_pivot", "joint"), seed=11, rig="pendulum", strength="weak", seconds=15.0)
    pivot = next(s for s in screen(fit, lively(fit)) if s.hypothesis.effect.name == "moving_pivot")
    assert pivot.evidence > 100.0
    assert pivot.noise["imu1.accel"] < 0.8 * fit.noise["imu1.accel"]


@pytest.mark.slow
def test_a_linear_step_foresees_what_a_refit_comes_to(fitted):
    _, fit, _ = fitted(("accel_bias", "imu1"))
    model = fit.model.with_effects((Hypothesis(EFFECTS["accel_bias"], "imu1"),))
    rows = all_rows(model, started(model, fit.state), fit.noise, fit.anchor, fit.loose)
    seen = linear_tally(model, rows)
    done = tally(solve(model, started(model, fit.state), fit.noise, fit.anchor, enough=1e-9))
    assert seen.keys() == done.keys()
    for name, (n, freedoms, cost) in done.items():
        assert seen[name][0] == n
        assert seen[name][1] == pytest.approx(freedoms, rel=0.02, abs=1.0)
        assert seen[name][2] == pytest.approx(cost, rel=0.01)
    before = tally(fit)
    assert aic_gain_of(fit.noise, before, fit.noise, seen) > 20.0


@pytest.mark.long
def test_a_refused_spline_hides_no_plain_effect(fitted):
    _, fit, _ = fitted(("accel_bias", "imu1"))
    spline, *plain = (
        Trial(Hypothesis(EFFECTS[name], at), fit, worth)
        for name, at, worth in (
            ("low_pass", "imu1", 90.0), ("accel_bias", "imu1", 60.0), ("accel_drift", "imu1", 58.0),
            ("gyro_bias", "imu1", 40.0), ("gyro_scale", "imu1", 20.0),
        )
    )  # fmt: skip
    good, equal, less, _ = plain
    assert asked([spline, *plain]) == [(spline, 0.0), (good, 0.0), (equal, 0.0), (less, 20.0)]
    assert asked(plain) == [(good, 0.0), (equal, 0.0), (less, 20.0)]


@pytest.mark.slow
def test_springs_are_begun_softer_where_a_refit_falls_short(tmp_path):
    """Strongly damped, promised at 20 Hz: from there they were worth nothing, and a soft mount stood for them."""
    told = {"frequency": [11.917158889487947, 8.658903893807198, 10.764229124581794], "gyration": 0.015}
    told |= {"damping_ratio": [0.2734832086314455, 0.2773319773202334, 0.15669623655713338]}
    told |= {"com": [-0.0025710096410160323, -0.0017079332936031752, 0.003655438280078205]}
    told |= {"lever": [0.011380372792559712, -0.0019773351005619895, 0.011799513975192652]}
    options = {"band": 1.81, "vigour": 0.7816649912222281, "rest": 0.12313001494282651, "declare_geometry": False}
    options |= {"gyro_noise": 0.0010819862437205544, "accel_noise": 0.037370614641033334, "rotation_std": 0.029}
    make_case(tmp_path / "r", "pendulum", [("rocking_mount", "imu1", told)], 20261126, seconds=15.0, **options)
    fit = nominal_fit(read(tmp_path / "r")[0])
    (one,) = screen(fit, [h for h in candidates(fit.model) if h.name == "rocking_mount@imu1"])
    best, *_ = state_trials(fit, [one.hypothesis], lambda _: None)
    assert best.evidence > SHORT * one.evidence
    assert softer(screen(fit, [h for h in candidates(fit.model) if h.effect.filters])[0]) is None


@pytest.mark.long
@pytest.mark.parametrize("frequency", [53.0, 30.0])
def test_a_hum_begins_where_the_samples_have_it_and_not_at_its_image_in_the_knots(tmp_path, frequency):
    """128 knots a second follow 53 Hz and leave 75; of 30 Hz they leave 30."""
    shaken = ("vibration", "imu1", {"frequency": frequency, "amplitude": [0.32, -0.02, 0.07]})
    make_case(tmp_path / "r", "free", [shaken], 7, seconds=14.0, rate=200.0)
    fit = begin(read(tmp_path / "r")[0]).fit
    assert hum_frequency(fit, "imu1") == pytest.approx(frequency, abs=0.1)
    assert strongest_line(fit, "imu1") == pytest.approx(128 - 53 if frequency == 53.0 else frequency, abs=0.1)
