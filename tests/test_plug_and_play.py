"""Algorithm 4 of Olsson 2020 on a stream: update by update, beside the batch, by seed, and on real recordings."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as budget
from hypothesis import strategies as st

from benchmarks.hinge_rigs import random_rig
from imubench import rotations
from imubench.convert.diodem import convert
from imubench.errors import InputError
from imubench.estimators.hinge_fit import descend
from imubench.estimators.olsson2020 import W_ACCEL, W_GYRO, solve
from imubench.estimators.plug_and_play import PlugAndPlay, Settings, at_rate, batches, estimate, uniform_start
from imubench.estimators.selection import select
from imubench.estimators.spherical import coordinates
from imubench.estimators.uncertainty import Acceptance, local_uncertainty, paper_covariance
from imubench.paired import Paired, paired
from imubench.recording import Imu, Recording
from imubench.reference_axes import reference_axes
from imubench.score import axis_deviation

NOISE = 0.0044, 0.015  # rad/s, m/s^2 a sample: an MTw at 50 Hz


def rig_of(seed=0, count=1500, amplitude=0.4, **options):
    """A noisy rig that moves slowly enough for Algorithm 3 to keep samples, E_th = 1 rad^2/s^2."""
    clean = random_rig(np.random.default_rng(seed), count, 50.0, **({"lever": 0.0, "amplitude": amplitude} | options))
    return clean.noisy(np.random.default_rng([1, seed]), *NOISE)


def samples_of(rig):
    return Paired(rig.time, rig.gyro[0], rig.accel[0], rig.gyro[1], rig.accel[1])


def run(samples, settings=None, seed=0):
    stream = PlugAndPlay(settings, np.random.default_rng(seed))
    return [stream.update(batch) for batch in batches(samples)]


def minimum(update, near):
    """The minimum of an update's cost from a given start; random ones now and then end in another one."""
    return descend(update.fit.constraints, coordinates(near)).axes


def still_rig():
    """Two sensors that nobody touches."""
    rig, rng = rig_of(count=1500), np.random.default_rng(5)
    noise = rng.normal(size=(2, 2, 1500, 3))
    return replace(rig, gyro=NOISE[0] * noise[0], accel=np.repeat(rig.accel[:, :1], 1500, axis=1) + NOISE[1] * noise[1])


# --- against the batch ---


def test_while_nothing_is_left_out_the_stream_solves_what_a_batch_does():
    rig = rig_of(count=1000)
    last = run(samples_of(rig))[-1]
    assert (last.fit.constraints.gyro_count, last.fit.constraints.accel_count) == (1000, 1000)
    batch, _ = solve(*rig.gyro, *rig.accel, coordinates(rig.axes), W_GYRO, W_ACCEL)
    assert last.estimate.details["cost"] == pytest.approx(batch.cost, rel=1e-9)  # 1e-10 a step is where both end
    assert axis_deviation(last.estimate.value, batch.axes).max() < 1e-6


@pytest.mark.parametrize("seconds", [1.0, 0.3, 7.0])
def test_with_the_memory_of_all_samples_the_stream_ends_where_the_batch_does(seconds):
    rig, settings = rig_of(1), Settings(n_max=300, memory="all")
    stream = PlugAndPlay(settings, np.random.default_rng(0))
    for batch in batches(samples_of(rig), seconds):
        last = stream.update(batch)
    chosen = select(*rig.gyro, *rig.accel, n_max=300)
    assert (np.sort(last.fit.samples.gyro) == np.sort(chosen.gyro)).all()
    assert (np.sort(last.fit.samples.accel) == np.sort(chosen.accel)).all()
    batch, _ = solve(chosen.gyro1, chosen.gyro2, chosen.accel1, chosen.accel2, coordinates(rig.axes), W_GYRO, W_ACCEL)
    assert axis_deviation(minimum(last, rig.axes), batch.axes).max() < 1e-6  # 1e-10 of the cost is where both end


def test_batches_are_seconds_and_lose_no_sample():
    samples = samples_of(rig_of(count=120))
    pieces = list(batches(samples))
    assert [piece.time.size for piece in pieces] == [50, 50, 20]
    assert (np.concatenate([piece.gyro2 for piece in pieces]) == samples.gyro2).all()


# --- what an update answers ---


def test_the_verdicts_are_those_of_algorithm_4_on_the_estimates():
    settings = Settings(n_min=4)
    updates = run(samples_of(rig_of()), settings)
    acceptance = Acceptance(settings.e_max, settings.n_min)
    for update in updates:
        again = acceptance.update(update.fit.best.axes, update.verdict.local)
        assert (again.accepted, again.worst_seqad) == (update.accepted, update.verdict.worst_seqad)
        exact = local_uncertainty(paper_covariance(update.fit.best), np.random.default_rng(9), 20_000)
        # 1000 draws: sigma / sqrt(2 L) = 2 % on sigma, twice that on mu + 2 sigma, four of them; angles stay angles.
        np.testing.assert_allclose(np.sin(update.verdict.local / 2), np.sin(exact / 2), rtol=0.2)
    first = next(k for k, update in enumerate(updates) if update.accepted)
    assert first >= settings.n_min  # n_min steps need one estimate more


def test_an_accepted_update_is_sure_and_one_that_is_not_says_what_is_missing():
    updates = run(samples_of(rig_of()))
    refused, accepted = updates[3], updates[-1]
    assert (refused.accepted, refused.estimate.status, refused.estimate.covariance) == (False, "not identifiable", None)
    assert refused.why == refused.estimate.no_covariance_because
    assert "the last 10 estimates moved by up to 180.0 deg" in refused.why
    assert (accepted.accepted, accepted.why, accepted.estimate.status) == (True, "", "converged")
    assert accepted.estimate.covariance.shape == (6, 6)
    assert 0 < accepted.estimate.details["honest_uncertainty_1"] < math.radians(3.0)


def test_accepted_estimates_are_right_and_keep_their_sign():
    rigs = [rig_of(seed) for seed in range(8)]
    streams = [[u.estimate.value for u in run(samples_of(rig)) if u.accepted] for rig in rigs]
    assert sum(len(values) > 0 for values in streams) >= 5  # some starts end in another minimum, and cost 10 s
    for rig, values in zip(rigs, streams, strict=True):
        assert all(axis_deviation(value, rig.axes).max() < math.radians(0.5) for value in values)  # noise: 0.02 deg
        assert all(np.sum(a * b) > 1.9 for a, b in pairwise(values))  # two axes, no flip


def test_sensors_at_rest_are_never_accepted():
    assert not any(update.accepted for update in run(samples_of(still_rig())))


def test_motion_that_is_always_fast_leaves_the_sign_to_chance():
    # Algorithm 3 keeps no sample above E_th, gyroscopes see no sign, and ten starts agree once in a while: a hole
    # of Algorithm 4, stated, not wished for. The guarded one refuses.
    rig = rig_of(1, count=20_000, amplitude=1.0)
    updates = run(samples_of(rig), Settings(n_min=3))[30:]
    assert {update.fit.constraints.accel_count for update in updates} == {0}
    off = [axis_deviation(u.estimate.value, rig.axes).max() for u in updates if u.accepted]
    assert 0.2 < np.mean(np.array(off) > 3.0) < 0.8  # rad; half of some 45 runs of three equal signs, four sigma


# --- randomness and symmetry ---


def test_the_same_seed_gives_the_same_bits_and_another_one_the_same_axes():
    samples = samples_of(rig_of(2))
    one, same, other = (run(samples, seed=seed)[-1].estimate for seed in (3, 3, 4))
    assert (one.value == same.value).all()
    np.testing.assert_array_equal(one.covariance, same.covariance)
    assert dict(one.details) == dict(same.details)
    assert one.details["local_uncertainty_1"] != other.details["local_uncertainty_1"]  # other draws
    assert axis_deviation(one.value, other.value).max() < 1e-6  # the solver's tolerance


def test_starts_fill_the_parameter_space():
    starts = np.array([uniform_start(np.random.default_rng(k)) for k in range(500)])
    assert (np.abs(starts).max(axis=0) <= np.array([0.5, 1.0, 0.5, 1.0]) * np.pi).all()
    assert (np.abs(starts).max(axis=0) > 0.97 * np.array([0.5, 1.0, 0.5, 1.0]) * np.pi).all()


@budget(max_examples=10, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([0, 1]))
def test_turning_a_sensor_turns_its_axis(seed, which):
    rig = rig_of(seed % 7, count=700)
    turned = rotations.random(np.random.default_rng(seed))
    gyro, accel = rig.gyro.copy(), rig.accel.copy()
    gyro[which], accel[which] = (rotations.rotate(turned, x[which]) for x in (rig.gyro, rig.accel))
    settings = Settings(n_max=300)
    before = minimum(run(samples_of(rig), settings)[-1], rig.axes)
    moved = replace(rig, gyro=gyro, accel=accel)
    start, expected = rig.axes.copy(), before.copy()
    start[which], expected[which] = (rotations.rotate(turned, x[which]) for x in (rig.axes, before))
    after = minimum(run(samples_of(moved), settings)[-1], start)
    assert axis_deviation(after, expected).max() < 1e-6  # the solver's tolerance


# --- on recordings ---


def test_the_first_accepted_estimate_of_a_recording_points_along_y():
    rig = rig_of(count=1500)
    answer = estimate(rig.recording())
    assert answer.status == "converged"
    assert answer.details["seconds"] == pytest.approx(10.98)  # eleven batches of 50 samples
    assert axis_deviation(answer.value, rig.axes).max() < math.radians(0.5)
    assert np.sum(answer.value * rig.axes) > 0


def test_a_recording_without_an_accepted_estimate_says_why():
    answer = estimate(still_rig().recording())
    assert answer.status == "not identifiable"
    assert "deg allowed" in answer.no_covariance_because


def test_windows_keep_their_length_at_any_rate():
    rig = rig_of(count=400)
    assert at_rate(samples_of(rig)).half_width == 10
    assert at_rate(samples_of(replace(rig, time=rig.time / 4))).half_width == 40


def test_one_imu_is_not_enough():
    rig = rig_of(count=100)
    with pytest.raises(InputError, match="expected two IMUs, got imu1"):
        estimate(Recording("one", "hinge", (Imu("imu1", rig.time, rig.gyro[0], rig.accel[0], 50.0),)))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"n_min": 0}, "n_min: expected at least 1, got 0"),
        ({"draws": 1}, "draws: expected at least 2, got 1"),
        ({"e_max": 0.0}, "e_max: expected"),
        ({"w0": -1.0}, "w0: expected"),
        ({"form": "scanned"}, "scanned"),
    ],
)
def test_settings_that_cannot_be(wrong, message):
    with pytest.raises(InputError, match=message):
        Settings(**wrong)


@pytest.mark.parametrize("segments", ["3-4", "4-5"])
def test_real_rigid_imus_are_accepted_and_right(recordings, segments):
    (out,) = convert(recordings / "diodem" / "trial1", segments, "rigid")
    true = reference_axes(out.recording, out.reference)
    samples = paired(out.recording)
    accepted = [u.estimate.value for u in run(samples, at_rate(samples)) if u.accepted]
    assert len(accepted) > 30  # of 67 s
    assert max(axis_deviation(value, true).max() for value in accepted) < Settings().e_max  # its promise


@pytest.mark.parametrize("segments", ["3-4", "4-5"])
def test_real_imus_on_foam_are_not_accepted_at_the_papers_settings(recordings, segments):
    (out,) = convert(recordings / "diodem" / "trial1", segments, "nonrigid")
    samples = paired(out.recording)
    assert not any(update.accepted for update in run(samples, at_rate(samples)))


@pytest.mark.parametrize(("segments", "off_deg"), [("3-4", 20.0), ("4-5", 20.0)])
def test_with_other_weights_it_accepts_imus_on_foam(recordings, segments, off_deg):
    # What the paper's method does, stated, not wished for: docs/plug-and-play.md. The guarded one refuses.
    (out,) = convert(recordings / "diodem" / "trial1", segments, "nonrigid")
    true, samples = reference_axes(out.recording, out.reference), paired(out.recording)
    settings = replace(at_rate(samples), w0=5.0)
    accepted = [u.estimate.value for u in run(samples, settings) if u.accepted]
    assert math.degrees(max(axis_deviation(value, true).max() for value in accepted)) > off_deg
