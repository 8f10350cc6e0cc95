"""What no effect explains, on physics of the independent generator that the table of effects does not have."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.discrepancy.basis_functions import curve, drifts, kinked, play
from imubench.diagnosis.discrepancy.best_term import best_term, follows_lone_accelerometer
from imubench.diagnosis.discrepancy.candidate_terms import jumps, terms
from imubench.diagnosis.discrepancy.fitted_terms import fitted_term as in_the_fit
from imubench.diagnosis.discrepancy.term_scores import colour, promising
from imubench.diagnosis.discrepancy.terms import LATE, Term, Unknown, UnknownTorque
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import fit_with_noise, with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import SWING_EQUATION
from imubench.diagnosis.result import UNKNOWN
from imubench.diagnosis.search.moves.swap_for_term import swapped_for_terms
from imubench.diagnosis.search.moves.term_rivals import comes_late
from imubench.diagnosis.search.selection import select
from imubench.diagnosis.search.unknown import unknowns
from imubench.diagnosis.solve.gauss_newton import all_rows, extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case


def fitted(folder, asked, seed, rig="hinge", seconds=12.0, **options):
    make_case(folder / "case", rig, effects=asked, seed=seed, seconds=seconds, **options)
    return nominal_fit(read(folder / "case")[0])


@pytest.fixture(scope="module")
def swinging(tmp_path_factory):
    """A hinge on a fixed base with a torque that follows its angle twelve times a turn."""
    folder = tmp_path_factory.mktemp("swinging")
    return fitted(folder, [("cogging", "joint", {"torque": 0.26, "cogs": 12.0})], 13, base="fixed", swing=True)


def test_functions_are_nothing_at_zero():
    x = np.append(np.random.default_rng(0).normal(size=200), 0.0)
    for basis in (curve(x), kinked(x)):
        np.testing.assert_allclose(basis[-1], 0.0, atol=1e-14)  # rounding
    np.testing.assert_allclose(drifts(np.linspace(3.0, 20.0, 300))[0], 0.0, atol=1e-14)


def test_play_follows_only_beyond_its_width():
    x = np.array([0.0, 0.5, 1.0, 2.0, 1.5, 0.5, -2.0])[:, None]
    np.testing.assert_allclose(play(x, np.array([1.0]))[:, 0], [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, -1.0])


def test_a_term_s_rows_are_linear_in_its_weights(swinging):
    chosen = [t for t in terms(swinging) if t.part in ("torque", "both") or t.goes_with == "its own reading"]
    assert {t.part for t in chosen} == {"gyro", "accel", "both", "torque"}
    rng = np.random.default_rng(1)
    for term in chosen:
        effect = (UnknownTorque if term.part == "torque" else Unknown)(term, 1.0)
        h = Hypothesis(effect, term.at)
        begun = extended(swinging, (h,))
        key, step = h.key("weight"), rng.normal(size=term.count)
        before = all_rows(begun.model, begun.state, begun.noise, begun.anchor)
        moved = type(begun.state)(begun.state.coefficients, begun.state.values | {key: step})
        after = all_rows(begun.model, moved, begun.noise, begun.anchor)
        changed = 0
        for one, two in zip(before, after, strict=True):
            block = one.residual.blocks.get((key, -1))
            if block is not None:
                change = two.residual.value - one.residual.value
                scale = np.abs(change).max()
                np.testing.assert_allclose(change, block @ step, atol=1e-9 * scale)  # linear: rounding alone
                changed += not one.name.startswith("prior") and scale > 0
        assert changed == (2 if term.part == "both" else 1), term.goes_with  # a clamped gyroscope reads the turn too


def test_a_jump_at_the_end_is_as_coloured_as_one_before(swinging):
    imu = swinging.model.recording.imus[1]
    end = imu.time[-1] - swinging.model.start
    middle, last = (colour(swinging, t) for t in jumps(swinging, imu, "gyro", np.array([end / 2, end - 0.9])))
    assert last > 0.5 * middle > 2.0


def test_a_cogging_joint_is_found_by_its_angle(swinging):
    strange = unknowns(swinging)
    found, fit = strange.findings, strange.fit
    assert [(f.effect, f.at) for f in found] == [(UNKNOWN, "joint")]
    assert found[0].where.depends_on == "the joint's angle, again and again"
    assert found[0].heldout_gain.ci[0] > 0
    # a sine of 0.26 N m has an RMS of 0.18 where the swing passes all of it
    assert found[0].parameters["torque_rms"].value == pytest.approx(0.18, rel=0.2)
    assert sum(isinstance(h.effect, UnknownTorque) for h in fit.model.hypotheses) == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "at", "seed", "options", "words"),
    [
        ("bias_jump", "imu1", 5, {}, "time: a jump at 4.5"),  # at 4.53 s
        ("cubic", "imu2", 4, {"strength": "strong"}, "its own reading"),
        ("hysteresis", "imu2", 6, {}, "its own reading and where it came from"),
        ("rectification", "imu1", 7, {"strength": "strong"}, "the accelerometer's shaking"),
        ("cross_talk", "imu2", 8, {}, "how the sensor turns and is pushed, a little later"),
        ("dead_band", "imu1", 9, {}, "its own reading"),
        ("thermal_walk", "imu2", 20, {}, "time"),
        ("creep", "imu1", 11, {}, "time: the sensor turns"),
    ],
)
def test_what_the_table_does_not_have_is_found_where_it_is(tmp_path, name, at, seed, options, words):
    found = unknowns(fitted(tmp_path, [(name, at)], seed, **options)).findings
    assert found[0].at == at
    assert found[0].where.at == at
    assert found[0].where.depends_on.startswith(words)
    assert found[0].heldout_gain.ci[0] > 0
    assert found[0].confidence > 0.9


@pytest.mark.slow
def test_what_a_lone_gyroscope_reads_late_is_seen_though_the_motion_follows_it(tmp_path):
    """Its residuals are none: they are the accelerometer's, which go with nothing that it reads itself."""
    talk = {"from": 0, "to": 2, "share": 0.034, "delay": 0.027}
    quick = {"band": 8.0, "vigour": 1.23, "gyro_noise": 0.00114, "accel_noise": 0.0259, "colour": 0.129}
    fit = fitted(tmp_path, [("cross_talk", "imu1", talk)], 48, rig="pendulum", **quick)
    fit = with_noise(refit(fit, (*fit.model.hypotheses, Hypothesis(EFFECTS["gyro_misalignment"], "imu1"))), 1)
    best = promising(fit)[0][0]
    assert best.term.part == "gyro" and 2 in best.term.channel
    assert best.term.goes_with.endswith(LATE)


@pytest.mark.slow
def test_a_scale_that_stood_in_for_a_cubic_sensor_gives_way(tmp_path):
    """A cubic accelerometer at imu2, which the selection takes for a scale of the other one."""
    fit = fitted(tmp_path, [("cubic", "imu2")], 16)
    fit = refit(fit, (*fit.model.hypotheses, Hypothesis(EFFECTS["accel_scale"], "imu1")))
    strange = unknowns(with_noise(fit, 1))
    found, after = strange.findings, strange.fit
    assert [f.at for f in found] == ["imu2"]
    assert {h.effect.name for h in after.model.hypotheses} == {UNKNOWN}


@pytest.mark.long
@pytest.mark.parametrize("options", [{}, {"colour": 0.2}, {"rig": "pendulum", "colour": 0.2}])
def test_noise_alone_raises_nothing(tmp_path, options):
    assert unknowns(fitted(tmp_path, [], 31, **options)).findings == ()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [32, 33, 34])
@pytest.mark.parametrize(
    "options",
    [
        {"colour": 0.2, "misdeclared": -0.15, "rest": 0.5},
        {"colour": 0.2, "band": 8.0},
        {"colour": 0.2, "base": "fixed"},
    ],
)
def test_coloured_noise_alone_raises_nothing(tmp_path, seed, options):
    assert unknowns(fitted(tmp_path, [], seed, **options)).findings == ()


def tightened(fit, times):
    """The fit of a motion that is held so many times as smooth."""
    tight = {n: std / times if n.startswith("smooth.") else std for n, std in fit.noise.items()}
    return solve(fit.model, fit.state, tight, fit.anchor)


@pytest.mark.slow
def test_a_motion_that_a_term_makes_smoother_is_no_mismatch(tmp_path):
    """What a limb's gyroscope reads is its motion: the term takes a share of it, and the splines' prior is content."""
    options = {"band": 2.86, "vigour": 0.71, "rest": 0.13, "gyro_noise": 0.0031, "accel_noise": 0.03, "gaps": 1}
    fit = fitted(tmp_path, [], 20261121 + 116, "pendulum", 15.0, **options)
    fit = tightened(fit, 64)
    (guess, *_), tried = promising(fit)
    assert guess.term.goes_with.startswith("how the sensor turns") and guess.white > 3 * EVIDENCE.clear_nat
    assert in_the_fit(fit, guess, float(np.log(tried))).evidence < 0.5 * EVIDENCE.clear_nat
    assert unknowns(fit).findings == ()


@pytest.mark.slow
def test_a_motion_held_too_smooth_is_no_mismatch(tmp_path):
    """What a limb turns that is rougher than the fit takes it for goes on in the residuals: 243 nat held out."""
    options = {"rate": 200.0, "band": 1.552, "vigour": 1.161, "rest": 0.0046, "gaps": 1, "misdeclared": -0.0973}
    options |= {"gyro_noise": 0.00362, "accel_noise": 0.01674, "position_std": 0.00233, "rotation_std": 0.03205}
    fit = tightened(fitted(tmp_path, [], 321279244, "pendulum", 15.0, **options), 256)
    (guess, *_), _ = promising(fit)
    assert guess.term.part == "gyro" and guess.white > 10 * EVIDENCE.clear_nat
    assert unknowns(fit).findings == ()


@pytest.mark.slow
def test_a_swing_s_equation_that_holds_ever_closer_is_no_term(tmp_path):
    """Dense knots and no friction: the level of the equation's residual fell with every round of the noise."""
    options = {"rate": 200.0, "rate2": 200.0, "band": 2.34, "vigour": 1.023, "rest": 0.028, "gaps": 1}
    options |= {"gyro_noise": 0.00134, "accel_noise": 0.0195, "position_std": 0.0032, "rotation_std": 0.024}
    scale = ("gyro_scale", "imu1", {"scale": [0.0096, 0.0106, 0.005]})
    fit = select(fitted(tmp_path, [scale], 447586266, "pendulum", 15.0, swing=True, **options)).fit
    assert [h.name for h in fit.model.hypotheses] == ["gyro_scale@imu1"]
    assert fit.noise[SWING_EQUATION] >= REML.law_floor
    assert unknowns(fit).findings == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "at", "parameters", "words"),
    [
        ("rectification", "imu1", {"factor": [0.01, -0.014, 0.008]}, "shaking"),
        ("accel_bias", "imu1", {"bias": [0.08, -0.1, 0.06]}, None),
    ],
)
def test_a_bias_that_goes_with_shaking_is_none(tmp_path, name, at, parameters, words):
    """Rectification has a mean: named first, it gives way to a term; a bias does not."""
    fit = fitted(tmp_path, [(name, at, parameters)], 41)
    fit = fit_with_noise(*_with(fit, "accel_bias", at), fit.anchor, rounds=2)
    assert len(swapped_for_terms(fit).terms) == (1 if words else 0)
    strange = unknowns(fit)
    found, after = strange.findings, strange.fit
    assert [(f.at, f.where.depends_on.split("'s ")[-1]) for f in found] == ([(at, words)] if words else [])
    assert any(h.effect.name == "accel_bias" for h in after.model.hypotheses) == (words is None)


def _with(fit, name, at):
    """Return the model, the state and the noise of a fit with an effect more."""
    more = refit(fit, (*fit.model.hypotheses, Hypothesis(EFFECTS[name], at)))
    return more.model, more.state, more.noise


@pytest.mark.parametrize(
    ("rig", "joint", "taken"), [("pendulum", "moving_pivot", True), ("hinge", "joint_play", False)]
)
def test_a_spline_follows_all_that_a_lone_accelerometer_reads(tmp_path, rig, joint, taken):
    make_case(tmp_path / "r", rig, [], 3, seconds=4.0)
    fit = nominal_fit(read(tmp_path / "r")[0])
    assert not follows_lone_accelerometer(fit)
    assert follows_lone_accelerometer(extended(fit, (Hypothesis(EFFECTS[joint], "joint"),))) == taken


@pytest.mark.slow
def test_a_walk_beside_a_bias_is_told_by_its_shape(tmp_path):
    walk = [("thermal_walk", "imu1", {"channel": "accel", "density": 0.008})]
    fit = fitted(tmp_path, walk, 62, "pendulum")
    fit = with_noise(refit(fit, (*fit.model.hypotheses, Hypothesis(EFFECTS["accel_bias"], "imu1"))), 2)
    best = best_term(fit)
    assert (best.term.at, best.term.part, best.term.goes_with) == ("imu1", "accel", "time")
    assert (
        best.evidence == best.shape > 2 * EVIDENCE.clear_nat
    )  # beside noise as coloured as it may be everywhere, 6 nat


def test_what_a_gyroscope_reads_late_is_no_misalignment_of_another():
    late = Term("imu1", "gyro", f"the reading of axis x, {LATE}", np.zeros(3), {}, ())
    assert comes_late(late, Hypothesis(EFFECTS["gyro_misalignment"], "imu1"))
    assert not comes_late(late, Hypothesis(EFFECTS["gyro_misalignment"], "imu2"))
    assert not comes_late(late, Hypothesis(EFFECTS["gyro_scale"], "imu1"))
    assert not comes_late(replace(late, goes_with="time"), Hypothesis(EFFECTS["gyro_misalignment"], "imu1"))
