"""Raw checks of clean, clipped, rounded and lost samples, on a small simulator and on real recordings."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.convert.broad import convert as convert_broad
from imubench.convert.diodem import convert as convert_diodem
from imubench.diagnosis.samples.checks import check, check_encoder
from imubench.diagnosis.samples.sample_faults import lattice
from imubench.recording import Encoder, Imu
from tests.raw_signals import ACCEL, GYRO, clipping, dropping, effects, found, imu, rounding


def random_clean(seed):
    """A recording without an effect: random rate, motion, rests, colour, declared noise, digits, gaps."""
    r = np.random.default_rng(900 + seed)

    def after(rng, t, gyro, accel):
        if seed % 3 == 1:
            gyro, accel = np.round(gyro, 6), np.round(accel, 6)
        keep = np.ones(t.size, dtype=bool)
        if seed % 4 == 2:
            a, b = r.integers(20, t.size - 60, 2)
            keep[a : a + 20], gyro[b], accel[b] = False, gyro[b - 1], accel[b - 1]
        return t[keep], gyro[keep], accel[keep]

    return imu(
        seed, rate=float(r.choice([50, 100, 200])), seconds=30.0, band=float(0.5 * 20 ** r.random()),
        rest=r.uniform(0, 0.4), rate_rms=r.uniform(0.3, 4), accel_rms=r.uniform(0.3, 10), colour=r.choice([0, 0.2]),
        noise=r.choice([0.87, 1.0, 1.15]), declared=r.random() < 0.7, after=after,
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(24))
def test_a_clean_recording_says_nothing(seed):
    recording = random_clean(seed)
    checks = check(recording)
    assert checks.findings == ()
    repeats = int(seed % 4 == 2)  # the one sample that says the last one again
    assert checks.masks["imu1.accel"].sum() <= 2 + repeats  # a wild draw may be left out, and little else


@pytest.mark.parametrize("rate", [50.0, 200.0])
def test_a_sensor_that_always_rests_says_nothing_and_tells_its_noise(rate):
    checks = check(imu(4, rate=rate, rest=0.0, rate_rms=1e-9, accel_rms=1e-9, colour=0.2, declared=False))
    assert checks.findings == ()
    assert sum(b - a for a, b in checks.still) > 0.7 * 60
    # white and coloured noise have 1.2 of the white's power; half-second pieces lose part of a slow colour
    assert GYRO * 0.97 < checks.noise["imu1.gyro"] < GYRO * 1.13
    assert 0 <= checks.colour["imu1.gyro"] < 0.2


def test_noise_without_rest_is_that_above_the_motion():
    checks = check(imu(5, rest=0.0, band=6.0, declared=False))
    assert not checks.still
    assert abs(checks.noise["imu1.accel"] / ACCEL - 1) < 0.05  # its error says 1 to 2 %
    assert abs(checks.noise["imu1.gyro"] / GYRO - 1) < 0.05


@pytest.mark.parametrize("share", [0.95, 0.7, 0.45])
def test_saturation_is_found_with_its_limit_and_its_samples(share):
    clean = imu(11)
    limit = share * np.abs(clean.gyro).max()
    clipped = imu(11, after=clipping(gyro_limit=limit))
    finding = found(clipped, "saturation")
    assert finding.settings == {"channels": ("gyro",)}
    assert abs(finding.parameters["limit"][0] - limit) < 1e-9  # the value itself is in the file
    checks = check(clipped)
    assert checks.masks["imu1.gyro"][(np.abs(clean.gyro) > limit).any(axis=1)].all()
    assert checks.masks["imu1.gyro"].sum() > (np.abs(clean.gyro) > limit).any(axis=1).sum()  # neighbours too
    assert not checks.masks["imu1.accel"].any()


def test_saturation_of_rounded_readings_is_found():
    def after(rng, t, gyro, accel):
        return rounding(0.004, 0.04)(rng, *clipping(accel_limit=8.0)(rng, t, gyro, accel))

    assert "saturation" in effects(imu(12, after=after))


@pytest.mark.parametrize("step", [0.02, 0.1, 0.3, 1.0, 4.0])
@pytest.mark.parametrize("rate_rms", [1e-9, 1.5])
def test_a_rounded_sensor_is_not_called_clipped_at_rest_or_in_motion(step, rate_rms):
    recording = imu(13, rate_rms=rate_rms, accel_rms=2 * rate_rms, after=rounding(0.1 * step, step))
    assert not effects(recording) & {"saturation", "impacts", "dropouts", "vibration"}


@pytest.mark.parametrize("step", [2.0, 5.0, 50.0])
def test_quantisation_is_found_from_twice_the_noise(step):
    finding = found(imu(21, after=rounding(step * GYRO, None)), "quantisation")
    assert finding.settings == {"channels": ("gyro",)}
    assert finding.parameters["step"][0] == pytest.approx(step * GYRO, rel=1e-6)


@pytest.mark.parametrize("step", [1e-3, 0.1, 0.5, 1.0])
def test_a_step_below_the_noise_is_no_mismatch(step):
    assert effects(imu(22, after=rounding(step * GYRO, step * ACCEL))) == set()


def test_a_lattice_is_read_off_its_values():
    rng = np.random.default_rng(3)
    assert lattice(0.005 * rng.integers(-50, 50, 4000) + 0.0013) == pytest.approx(0.005)
    assert lattice(rng.normal(size=4000)) == 0.0
    assert lattice(np.full(100, 9.81)) == 0.0
    few = rng.integers(-800, 800, 750)  # a short recording of a wide motion: the median gap is two steps
    assert np.median(np.diff(np.unique(few))) == 2
    assert lattice(0.0044 * few) == pytest.approx(0.0044)
    assert lattice(np.round(rng.normal(size=750), 6)) == 0.0  # digits of a text file


@pytest.mark.parametrize("fraction", [0.02, 0.1, 0.25])
@pytest.mark.parametrize("mode", ["held", "missing"])
def test_dropouts_are_found_with_their_share(fraction, mode):
    clean = imu(31)
    lossy = imu(31, after=dropping(fraction, mode))
    finding = found(lossy, "dropouts")
    assert finding.settings == {"mode": mode}
    value, std, _ = finding.parameters["fraction"]
    assert abs(value - fraction) < 4 * std < 0.03
    if mode == "held":
        repeats = (np.diff(lossy.gyro, axis=0, prepend=1) == 0).all(axis=1)
        assert np.array_equal(check(lossy).masks["imu1.gyro"], repeats)
        assert not (np.diff(clean.gyro, axis=0, prepend=1) == 0).all(axis=1).any()


def test_held_samples_are_told_from_the_steps_of_a_rounded_sensor():
    rounded = rounding(0.01, 0.1)
    both = imu(32, after=lambda rng, t, g, a: dropping(0.1, "held")(rng, *rounded(rng, t, g, a)))
    fraction = {f.effect: f for f in check(both).findings}["dropouts"].parameters["fraction"]
    assert abs(fraction[0] - 0.1) < 0.03  # by chance, rounded samples repeat as well
    assert "dropouts" not in effects(imu(32, after=rounded))


def test_a_wrong_nominal_rate_and_uneven_stamps_are_no_dropouts():
    clean = imu(33)
    for rate, time in (
        (50.0, clean.time),
        (200.0, clean.time),
        (100.0, np.round(clean.time * 0.35, 3)),  # 3 and 4 ms in turn
        (100.0, clean.time + np.random.default_rng(1).uniform(-0.004, 0.004, clean.time.size)),
    ):
        other = Imu("imu1", time, clean.gyro, clean.accel, rate)
        assert "dropouts" not in effects(other)


def test_a_short_recording_says_nothing():
    clean = imu(71, seconds=20.0)
    for n in (1, 2, 10, 40, 200):
        short = Imu("imu1", clean.time[:n], clean.gyro[:n], clean.accel[:n], 100.0, gyro_noise_std=GYRO)
        assert check(short).findings == ()


def test_an_encoders_step_is_its_noise():
    time = np.arange(3000) / 100
    angle = np.round(np.sin(time) / 0.002) * 0.002
    checks = check_encoder(Encoder("hinge", time, angle))
    assert checks.noise["encoder.angle"] == pytest.approx(0.002 / np.sqrt(12))
    assert not checks.masks["encoder.angle"].any()


BROAD = {
    "07_undisturbed_fast_rotation_B": set(),
    "24_disturbed_tapping_A": {"impacts"},
    "27_disturbed_phone_vibration_B": {"vibration"},
}


@pytest.mark.parametrize("name", BROAD)
def test_real_broad(name, recordings):
    recording = convert_broad(recordings / "broad" / f"{name}.hdf5")[0].recording.imus[0]
    checks = check(recording)
    assert {f.effect for f in checks.findings} == BROAD[name]
    assert 0.0015 < checks.noise["imu1.gyro"] < 0.0022 and checks.colour["imu1.gyro"] < 0.2  # 1.5 to 1.8e-3 by hand
    for finding in checks.findings:
        if finding.effect == "impacts":  # the accelerometer shows 22 peaks over 45 m/s^2, one tap each
            times = finding.parameters["times"][0]
            size = np.linalg.norm(recording.accel, axis=1)
            assert times.size == 22
            for start in times:
                near = (recording.time > start - 0.01) & (recording.time < start + 0.05)
                assert size[near].max() > 40.0
        else:  # a spectrogram shows a line that sinks from 45 to 42 Hz, from 71 to 163 s
            value, std, _ = finding.parameters["frequency"]
            assert 43.0 < value < 45.2 and std < 1.5
            begin, end = max(finding.windows, key=lambda w: w[1] - w[0])
            assert abs(begin - 71) < 4 and abs(end - 163) < 4


@pytest.mark.parametrize("segments", ["2-3", "3-4", "4-5"])
@pytest.mark.parametrize("mount", ["rigid", "nonrigid"])
def test_real_diodem_says_nothing(segments, mount, recordings):
    recording = convert_diodem(recordings / "diodem" / "trial1", segments=segments, imu=mount)[0].recording
    for sensor in recording.imus:
        told = replace(sensor, gyro_noise_std=GYRO, accel_noise_std=ACCEL)  # a tenth of what motion leaves above 12 Hz
        checks = check(sensor)
        assert checks.findings == () and check(told).findings == () and not checks.masks[f"{sensor.name}.accel"].any()
