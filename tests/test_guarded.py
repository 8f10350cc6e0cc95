"""The guard of Algorithm 4: its figures against refits, what it refuses, what it lets pass, and real recordings."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.banded import case
from benchmarks.coverage import CASES, leaning
from benchmarks.hinge_rigs import random_rig
from benchmarks.real_axes import carried_axes
from imubench.convert.diodem import convert
from imubench.errors import InputError
from imubench.estimators.banded import estimate as banded
from imubench.estimators.banded import explained
from imubench.estimators.guarded import (
    Guard,
    GuardedPlugAndPlay,
    _along_to_across,
    bias_spread,
    coherent_error,
    estimate,
    jackknife_spread,
    postures,
    question,
    residuals,
    rival_coherence,
)
from imubench.estimators.hinge_constraints import weigh
from imubench.estimators.hinge_fit import covariance, descend
from imubench.estimators.plug_and_play import Fit, PlugAndPlay, Settings, at_rate, batches
from imubench.estimators.selection import Selected
from imubench.estimators.spherical import coordinates
from imubench.estimators.uncertainty import two_sigma
from imubench.paired import Paired, paired
from imubench.reference_axes import reference_axes
from imubench.score import axis_deviation

NOISE = 0.0044, 0.015  # rad/s, m/s^2 a sample: an MTw at 50 Hz
WEIGHTS = Settings().weights
E_MAX = Settings().e_max


def rig_of(seed=0, count=1000, amplitude=0.4, noise=1.0):
    clean = random_rig(np.random.default_rng(seed), count, 50.0, lever=0.0, amplitude=amplitude)
    return clean.noisy(np.random.default_rng([1, seed]), *(noise * np.array(NOISE)))


def samples_of(rig):
    return Paired(rig.time, rig.gyro[0], rig.accel[0], rig.gyro[1], rig.accel[1])


def fit_of(rig):
    """A fit of all samples from the truth, and with the other pairing's minimum."""
    every = np.arange(rig.time.size)
    c = weigh(*rig.gyro, *rig.accel, *WEIGHTS)
    best, other = (descend(c, coordinates(rig.axes * [[1.0], [sign]]), 1e-14) for sign in (1.0, -1.0))
    return Fit(Selected(every, every, *rig.gyro, *rig.accel), c, best, other)


def moved(fit, rig):
    """By how much (4,) the minimum of a disturbed rig lies from that of `fit`, rad in its chart."""
    c = weigh(*rig.gyro, *rig.accel, *WEIGHTS)
    return np.einsum("itk,ik->it", fit.best.tangents, descend(c, fit.best.x, 1e-14).axes).ravel()


def both(samples, settings=None, seed=0, guard=None):
    plain = PlugAndPlay(settings, np.random.default_rng(seed))
    careful = GuardedPlugAndPlay(settings, np.random.default_rng(seed), guard)
    return [(plain.update(batch), careful.update(batch)) for batch in batches(samples)]


# --- the figures ---


@pytest.mark.parametrize("kind", ["gyro", "accel"])
def test_what_biases_do_is_what_a_refit_finds(kind):
    rig, bias = rig_of(noise=0.02), 1e-4  # rad/s or m/s^2: small enough for the first order
    fit, expected = fit_of(rig), np.zeros((4, 4))
    for i in range(2):
        for axis in np.eye(3):
            signal = getattr(rig, kind).copy()
            up, down = signal.copy(), signal.copy()
            up[i] += bias * axis
            down[i] -= bias * axis
            step = 0.5 * (moved(fit, replace(rig, **{kind: up})) - moved(fit, replace(rig, **{kind: down})))
            expected += np.outer(step, step)
    guard = Guard(bias if kind == "gyro" else 0.0, bias if kind == "accel" else 0.0)
    found = bias_spread(fit, Settings(), guard)
    # 3 %: of the few samples where |w x j| passes through the noise, the guard takes the expected second derivatives.
    np.testing.assert_allclose(found, expected, atol=0.03 * np.abs(expected).max())


def test_no_error_as_large_as_the_residuals_turns_the_axes_further_than_the_bound():
    rig = rig_of(noise=0.02)
    fit, rng = fit_of(rig), np.random.default_rng(2)
    bound, furthest = coherent_error(fit), np.zeros(2)
    gyro_size, accel_size = (np.linalg.norm(e) for e in residuals(fit.constraints, fit.best.axes))
    parts = rig.gyro[0] @ fit.best.frames[0].T
    across = np.linalg.norm(parts[:, 1:], axis=1, keepdims=True)
    unit = parts[:, 1:] / across @ fit.best.tangents[0]  # along which |w1 x j1| grows
    # How turns of axis 1 show, and noise: the worst shapes an error can have, and harmless ones.
    gyro_shapes = [*(parts[:, :1] * parts[:, 1:] / across).T, rng.normal(size=1000)]
    accel_shapes = [*(rig.accel[0] @ fit.best.tangents[0].T).T, rng.normal(size=1000)]
    for shape in gyro_shapes:
        rates = rig.gyro.copy()
        rates[0] += gyro_size / WEIGHTS[0] * (shape / np.linalg.norm(shape))[:, None] * unit
        furthest = np.maximum(furthest, np.abs(moved(fit, replace(rig, gyro=rates))).reshape(2, 2).max(axis=1))
    for shape in accel_shapes:
        forces = rig.accel.copy()
        forces[0] += accel_size / WEIGHTS[1] * (shape / np.linalg.norm(shape))[:, None] * fit.best.axes[0]
        furthest = np.maximum(furthest, np.abs(moved(fit, replace(rig, accel=forces))).reshape(2, 2).max(axis=1))
    assert (furthest < bound).all()
    assert furthest[0] > 0.3 * bound[0]  # the worst shapes come near it


def test_white_noise_spreads_as_the_jackknife_says():
    fit = fit_of(rig_of(count=2000))
    jackknife, white = jackknife_spread(fit, Settings(), 10), covariance(fit.constraints, fit.best)
    # Ten pieces: chi-square of 9 degrees a direction, and fewer postures for accelerometers; a factor of 2 in angle.
    ratio = two_sigma(jackknife) / two_sigma(white)
    assert ((ratio > 0.5) & (ratio < 2.0)).all()


def test_a_posture_ends_when_gravity_has_turned_a_quarter_radian():
    angles = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.56, 0.5, 0.0])
    rows = np.stack([np.cos(angles), np.sin(angles), *np.zeros((4, 9))], axis=1)
    assert postures(9.81 * rows).tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 3]
    assert postures(np.empty((0, 6))).size == 0


def test_along_to_across_is_a_tangent():
    assert _along_to_across(np.array([3.0, 4.0]), np.array([5.0, 0.0])) == pytest.approx(0.75)
    assert _along_to_across(np.array([3.0, 4.0]), np.zeros(2)) == 0.0


def test_rivals_count_by_what_they_would_need():
    fit = fit_of(rig_of())
    assert rival_coherence(fit, [fit.best]) > 1.0  # the other pairing explains it much worse
    assert rival_coherence(replace(fit, other=fit.best), [fit.best]) == math.inf  # none
    swapped = replace(fit, best=fit.other, other=fit.best)
    assert rival_coherence(swapped, [fit.best]) == 0.0  # the rival is the better one


def test_the_first_objection_ends_the_questions():
    fit = fit_of(rig_of())
    figures, why = question(fit, [fit.best], Settings(e_max=1e-6), Guard())
    assert list(figures) == ["residual_bound"]
    assert why.startswith("what the hinge leaves unexplained could turn an axis by")
    figures, why = question(fit, [fit.best], Settings(), Guard())
    assert list(figures) == ["residual_bound", "bias_bound", "pieces_bound", "rival_coherence"]
    assert why == ""


# --- what it lets pass, and what not ---


def test_the_guard_only_ever_refuses():
    for plain, careful in both(samples_of(rig_of(count=1500))):
        assert not careful.accepted or plain.accepted
        np.testing.assert_array_equal(careful.estimate.value, plain.estimate.value)
        assert careful.verdict.local.tolist() == plain.verdict.local.tolist()
        if not careful.accepted:
            assert careful.why
            assert careful.estimate.covariance is None


def test_good_rigs_are_accepted_with_the_figures():
    answer = estimate(rig_of(count=2000).recording())
    assert answer.status == "converged"
    assert axis_deviation(answer.value, rig_of(count=2000).axes).max() < math.radians(0.5)  # noise: 0.02 deg
    assert {"residual_bound", "bias_bound", "pieces_bound", "rival_coherence"} <= set(answer.details)


def test_larger_biases_are_guarded_against_when_it_is_told():
    samples = samples_of(rig_of(count=1500))
    told = both(samples, guard=Guard(accel_bias_std=3.0))
    assert any(careful.accepted for _, careful in both(samples))
    assert not any(careful.accepted for _, careful in told)
    assert any(careful.why.startswith("sensor biases could turn an axis by") for _, careful in told)


@pytest.mark.long
def test_a_sign_left_to_chance_is_not_accepted():
    # All motion is fast, Algorithm 3 keeps no accelerometer sample, and Algorithm 4 accepts either pairing.
    updates = both(samples_of(rig_of(1, count=20_000, amplitude=1.0)), Settings(n_min=3))[30:]
    assert any(plain.accepted for plain, _ in updates)
    assert not any(careful.accepted for _, careful in updates)


@pytest.mark.slow
def test_of_mounts_that_lean_no_wrong_axis_is_accepted():
    wrong, right = np.zeros(2), np.zeros(2)  # plain, guarded
    for seed in range(25):
        one = leaning(seed)
        pairs = both(samples_of(one), seed=seed)
        for k in range(2):
            off = [axis_deviation(p[k].estimate.value, one.axes).max() for p in pairs if p[k].accepted]
            wrong[k] += any(angle > E_MAX for angle in off)
            right[k] += bool(off) and off[0] <= E_MAX
    assert wrong[0] > 0  # which is what the guard is for
    assert wrong[1] == 0
    assert right[1] > 0


@pytest.mark.long
def test_biases_of_the_papers_size_pass_and_are_right():
    accepted = 0
    for seed in range(10):
        one = CASES["biases of 0.5 deg/s and 0.1 m/s^2"](seed)
        off = [axis_deviation(c.estimate.value, one.axes).max() for _, c in both(samples_of(one)) if c.accepted]
        accepted += bool(off)
        assert all(angle < E_MAX for angle in off)
    assert accepted > 5


@pytest.mark.parametrize(
    ("wrong", "message"),
    [({"coherence": -0.1}, "coherence"), ({"groups": 1}, "groups"), ({"gyro_bias_std": math.nan}, "gyro_bias_std")],
)
def test_guards_that_cannot_be(wrong, message):
    with pytest.raises(InputError, match=message):
        Guard(**wrong)


# --- real recordings ---


@pytest.mark.parametrize("segments", ["3-4", "4-5"])
def test_real_rigid_imus_are_accepted_and_right(recordings, segments):
    (out,) = convert(recordings / "diodem" / "trial1", segments, "rigid")
    true, samples = reference_axes(out.recording, out.reference), paired(out.recording)
    accepted = [careful.estimate.value for _, careful in both(samples, at_rate(samples)) if careful.accepted]
    assert len(accepted) > 20  # of 67 s
    assert max(axis_deviation(value, true).max() for value in accepted) < E_MAX


@pytest.mark.parametrize("segments", ["3-4", "4-5"])
@pytest.mark.parametrize(
    "options",
    [
        {},
        *(
            pytest.param(o, marks=pytest.mark.long)
            for o in ({"w0": 5.0}, {"n_min": 3}, {"n_min": 3, "e_max": math.radians(6.0)})
        ),
    ],
)
def test_real_imus_on_foam_are_refused(recordings, segments, options):
    # But for the first, Algorithm 4 accepts, 24 to 56 deg off, on at least one of the two joints.
    (out,) = convert(recordings / "diodem" / "trial1", segments, "nonrigid")
    samples = paired(out.recording)
    assert not any(careful.accepted for _, careful in both(samples, replace(at_rate(samples), **options)))


@pytest.mark.long
def test_what_is_refused_is_offered_below_a_band_and_labelled_so(recordings):
    """On foam: with the guard's consent only what is right; the rest is offered, too, but is not `converged`."""
    status = {}
    for segments in ("3-4", "4-5"):
        (rigid,), (foam,) = (
            convert(recordings / "diodem" / "trial1", segments, kind) for kind in ("rigid", "nonrigid")
        )
        answer = estimate(foam.recording)
        assert answer.details["offered_instead"] == 1.0
        assert answer.covariance is not None
        true = carried_axes(reference_axes(rigid.recording, rigid.reference), rigid.recording, foam.recording)
        if answer.status == "converged":  # the promise of the guard
            assert axis_deviation(answer.value, true).max() < E_MAX
        assert "offered instead" in explained(answer)
        status[segments] = answer.status
    assert status == {"3-4": "converged", "4-5": "not converged"}


@pytest.mark.long
def test_a_soft_rig_that_is_refused_is_offered_below_a_band():
    one = case(1006)  # IMUs that rock: nothing of the stream is accepted
    answer, below = estimate(one.recording), banded(one.recording)
    assert answer.details["offered_instead"] == 1.0
    assert (answer.estimator, below.estimator) == ("olsson2020-guarded", "olsson2020-banded")
    np.testing.assert_array_equal(answer.value, below.value)
    np.testing.assert_array_equal(answer.covariance, below.covariance)
    assert {"residual_bound", "seconds", "band"} <= set(answer.details)


def test_what_shows_no_axes_stays_refused():
    rig = rig_of(count=800)
    still = replace(rig, gyro=0 * rig.gyro, accel=np.repeat(rig.accel[:, :1], 800, axis=1))
    answer = estimate(still.recording())
    assert answer.status == "not identifiable"
    assert "offered_instead" not in answer.details
