"""Samples at a lower rate: the motion as it was, the noise white and as quiet as it is said to be."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from imubench.diagnosis import pipeline
from imubench.diagnosis.noise.decimation import at_rate, decimated, end_of
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.problem.averaging import Averaging
from imubench.diagnosis.problem.bspline import DEGREE
from imubench.diagnosis.rules import RuleUse
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.solve.initialize import model_of
from imubench.format1 import read
from imubench.progress import silent
from imubench.proof.case import make_case
from imubench.recording import Imu

RATE, LOWER = 100.0, 27.0  # Hz


@pytest.fixture(scope="module")
def make(tmp_path_factory):
    def case(*asked, **options):
        folder = tmp_path_factory.mktemp("case") / "r"
        make_case(folder, *asked, **{"seconds": 30.0, "rate": RATE} | options)
        return read(folder)[0]

    return case


@pytest.fixture(scope="module")
def clean(make):
    return make("hinge", [], 31)


def imu_of(readings, rate=RATE):
    time = np.arange(len(readings)) / rate
    return Imu("imu1", time, readings, readings, rate, 0.3, 0.5)


@pytest.mark.parametrize(("frequency", "off"), [(0.0, 1e-12), (2.0, 3e-6), (5.0, 3e-6), (8.0, 1e-4)])
def test_what_is_below_the_filter_stays_as_it_is(frequency, off):
    """The filter is flat to 9 Hz, and a window ends its weights, which shows near there."""
    time = np.arange(3000) / RATE
    imu, _ = at_rate(imu_of(np.cos(2 * np.pi * frequency * time)[:, None] * np.ones(3)), LOWER)
    assert imu.gyro == pytest.approx(np.cos(2 * np.pi * frequency * imu.time)[:, None] * np.ones(3), abs=off)


def test_what_is_above_the_new_rate_is_gone():
    """From (1 + 1/3) 27 / 2 Hz on nothing passes but what the ends of the weights let through."""
    time = np.arange(3000) / RATE
    for frequency in (19.0, 30.0, 45.0):
        imu, _ = at_rate(imu_of(np.cos(2 * np.pi * frequency * time)[:, None] * np.ones(3)), LOWER)
        assert np.abs(imu.gyro).max() < 5e-4


def test_white_noise_stays_white_and_is_as_quiet_as_told():
    readings = np.random.default_rng(1).normal(size=(40_000, 3))
    imu, share = at_rate(imu_of(readings), LOWER)
    n = imu.gyro.size
    assert share == pytest.approx(np.sqrt(LOWER / RATE), rel=0.01)  # the window
    assert (imu.gyro_noise_std, imu.accel_noise_std) == (pytest.approx(0.3 * share), pytest.approx(0.5 * share))
    assert imu.gyro.std() == pytest.approx(share, rel=4 / np.sqrt(2 * n))
    for lag in (1, 2, 3):
        same = np.mean(imu.gyro[lag:] * imu.gyro[:-lag]) / share**2
        assert abs(same) < 0.01 + 4 / np.sqrt(n)  # the window


def test_a_motion_ends_where_it_is_no_more_than_the_noise():
    rng = np.random.default_rng(2)
    time = np.arange(4000) / RATE
    noise = rng.normal(size=(4000, 3))
    assert end_of(noise, RATE) == 0.0
    moved = noise + 3 * np.cos(2 * np.pi * 6.0 * time)[:, None] * [1.0, 0.0, 0.0]
    assert 6.0 < end_of(moved, RATE) < 8.0
    coloured = noise + 2 * np.cumsum(noise, axis=0) * 0.5 ** np.arange(3)  # louder the slower, far up
    assert end_of(coloured, RATE) > 10.0


def test_ends_of_white_noise_are_rarely_false():
    rng = np.random.default_rng(3)
    assert sum(end_of(rng.normal(size=(3000, 3)), RATE) > 0 for _ in range(200)) <= 2


def test_a_recording_is_taken_at_a_lower_rate(clean):
    found = decimated(clean, check_samples(clean))
    rates = {imu.rate for imu in found.recording.imus}
    assert len(rates) == 1
    assert 25.0 <= rates.pop() < 40.0
    assert set(found.averaging.shares) == {"imu1.gyro", "imu1.accel", "imu2.gyro", "imu2.accel"}
    assert len(found.notes) == 1
    for before, after in zip(clean.imus, found.recording.imus, strict=True):
        assert after.gyro_noise_std == pytest.approx(
            before.gyro_noise_std * found.averaging.share(f"{before.name}.gyro")
        )


def test_stamps_that_wander_change_nothing(clean):
    rng = np.random.default_rng(4)
    imus = tuple(replace(i, time=i.time + 0.1 / RATE * rng.uniform(-1, 1, i.time.size)) for i in clean.imus)
    wandering = replace(clean, imus=imus)
    assert decimated(wandering, check_samples(wandering)).recording is wandering


@pytest.mark.parametrize("effect", ["impacts", "vibration", "saturation", "dropouts", "quantisation"])
def test_what_has_no_end_in_frequency_changes_nothing(make, effect):
    recording = make("hinge", [(effect, "imu2")], 32)
    assert decimated(recording, check_samples(recording)).recording is recording


def test_free_swings_change_nothing(make):
    recording = make("pendulum", [], 33, swing=True)
    assert recording.free_swings
    assert decimated(recording, check_samples(recording)).recording is recording


def test_springs_that_ring_are_kept(make):
    """A mount that rocks at 17 Hz is sampled above twice that, or as it was."""
    recording = make("hinge", [("rocking_mount", "imu2")], 34, strength="strong")
    found = decimated(recording, check_samples(recording))
    ends = end_of(recording.imus[1].gyro, RATE)
    assert ends > 8.0
    assert found.recording.imus[1].rate > 2 * ends


def test_noise_is_told_as_the_recording_has_it(make):
    """Beside a fit of samples at a lower rate: the declared levels, and by how much one is louder."""
    recording = make("hinge", [("gyro_noise", "imu1")], 35)
    diagnosis, evidence = diagnose(recording)
    declared = recording.imus[0]
    assert any("noise alone" in note for note in evidence.notes)
    assert diagnosis.noise["imu1.accel"].std == pytest.approx(declared.accel_noise_std)
    assert {level.group: level.used for level in evidence.levels} == {n: x.std for n, x in diagnosis.noise.items()}
    louder = next(f for f in diagnosis.findings if f.effect == "gyro_noise")
    high = np.diff(declared.gyro, n=6, axis=0).std() / np.sqrt(924)  # of sixth differences, which no motion has
    assert float(louder.parameters["std"].value) == pytest.approx(high, rel=0.1)
    assert diagnosis.sensors[0].rate == RATE


def test_time_counts_from_the_first_stamp_of_the_recording(clean):
    """A clock's skew, a drift and a slip are told of times from there, wherever the fit's first sample is."""
    found = decimated(clean, check_samples(clean))
    first = min(imu.time[0] for imu in clean.imus)
    assert found.averaging.zero == first
    model = model_of(found.recording, averaging=found.averaging)
    assert model.start == first
    knots, last = model.tracks.knots, found.recording.imus[0].time[-1] - first
    assert knots.start < found.recording.imus[0].time[0] - first
    assert knots.start + knots.step * (knots.count - DEGREE) > last


@pytest.mark.parametrize(
    ("shares", "left", "missed", "asked"),
    [
        ({"imu1.gyro": 0.5}, ["something"], [], [False, True]),
        ({"imu1.gyro": 0.5}, [], [], [False]),
        ({"imu1.gyro": 0.5}, ["something"], ["the search"], [False]),  # no time is left
        ({}, ["something"], [], [False]),  # they were all the samples
    ],
)
def test_every_sample_is_asked_where_fewer_leave_something(monkeypatch, shares, left, missed, asked):
    calls = []

    def begun(recording, step, budget, learned, every_sample):
        calls.append(every_sample)
        first = SimpleNamespace(model=SimpleNamespace(averaging=Averaging({} if every_sample else shares)))
        return SimpleNamespace(first=first, finished=True)

    use = RuleUse()
    use.fires("add")
    work = SimpleNamespace(recording=None, step=silent, budget=SimpleNamespace(not_tried=missed), learned=None, use=use)
    monkeypatch.setattr(pipeline, "begin", begun)
    monkeypatch.setattr(pipeline, "not_observable", lambda recording: ())
    monkeypatch.setattr(pipeline, "searched", lambda work, start: None)
    monkeypatch.setattr(pipeline, "explained", lambda work, start, chosen: SimpleNamespace(rest=left))
    pipeline.answered(work)
    assert calls == asked
    assert use.fired == ({} if asked[-1] else {"add": 1})


@pytest.mark.slow
def test_a_soft_mount_that_rings_beneath_the_noise_is_found(make):
    """Its frequency is above what the motion needs: 27 Hz of samples leave something without a name."""
    recording = make("hinge", [("soft_mount", "imu1")], 1028, "weak", seconds=40.0, rate=60.0)
    assert decimated(recording, check_samples(recording)).averaging.shares
    diagnosis, evidence = diagnose(recording)
    assert [(f.effect, f.at) for f in diagnosis.findings] == [("soft_mount", "imu1")]
    assert not any("noise alone" in note for note in evidence.notes)
