"""Residuals made by hand: what is loud, when, at which frequencies and with what is found again."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from imubench.diagnosis.evidence import Trace
from imubench.diagnosis.residual_checks.localize import NOTHING, Regressors, acting_in, locate
from imubench.diagnosis.residual_checks.regressors import reversals
from imubench.diagnosis.result import Where
from imubench.diagnosis.samples.spectra import spectrum

RATE, SECONDS = 100.0, 60.0
TIME = np.arange(round(RATE * SECONDS)) / RATE
AXES = "xyz"
WHERE = Where("imu1", {"acc_z": 0.9}, ((1.0, 2.0),), ((0.0, 60.0),), NOTHING, 0.9)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def traces(rng, loud=None, time=TIME, noise=0.02):
    """Two IMUs of white noise; `loud` {(imu, part, axis): (n,) in units of the noise} is added."""
    out = []
    for at in ("imu1", "imu2"):
        for part, prefix, unit in (("gyro", "gyr", "rad/s"), ("accel", "acc", "m/s^2")):
            z = rng.normal(size=(time.size, 3))
            for i, axis in enumerate(AXES):
                z[:, i] += (loud or {}).get((at, part, axis), 0.0)
            out.append(Trace(at, part, tuple(f"{prefix}_{a}" for a in AXES), unit, time, noise * z, noise))
    return out


def swinging(time=TIME):
    """A slow swing and a quick one that comes and goes: rate, acceleration and angle are large at different times."""
    angle = np.sin(2 * np.pi * 0.3 * time) + 0.1 * np.sin(2 * np.pi * 1.3 * time) * np.sin(2 * np.pi * 0.02 * time)
    rate = np.gradient(angle, time)
    return {
        "angular rate": np.abs(rate),
        "angular acceleration": np.abs(np.gradient(rate, time)),
        "hinge angle": np.abs(angle),
        "hinge reversals": reversals(time, rate),
    }


def everywhere(values, time=TIME):
    return {at: Regressors(time, values) for at in ("imu1", "imu2")}


def band(rng, low, high, n=TIME.size):
    x = sosfiltfilt(butter(6, (low, high), "band", fs=RATE, output="sos"), rng.normal(size=n))
    return x / x.std()


def test_noise_alone_is_nowhere(rng):
    assert locate(traces(rng), everywhere(swinging())) == ()


def test_a_burst_is_found_in_its_sensor_channels_window_and_band(rng):
    burst = band(rng, 9.0, 16.0) * ((TIME > 20) & (TIME < 27))
    found = locate(traces(rng, {("imu2", "accel", "x"): 4 * burst, ("imu2", "accel", "z"): 2 * burst}), {})
    assert [w.at for w in found] == ["imu2"]
    (where,) = found
    assert where.share > 0.99
    assert list(where.channels) == ["acc_x", "acc_z"]
    # 4^2 and 2^2 of their sum; the burst's own scatter is the same in both, noise adds under 0.02
    assert where.channels["acc_x"] == pytest.approx(0.8, abs=0.02)
    (window,) = where.windows_s
    assert window == pytest.approx((20, 27), abs=0.51)  # bins are 0.5 s
    (low, high) = where.bands_hz[0]
    assert len(where.bands_hz) == 1
    assert 8.0 < low < 10.5  # the filter's skirts lie within a hertz, and only 80 % of the power is asked for
    assert 14.5 < high < 17.0
    assert where.depends_on == NOTHING


def test_two_windows_and_two_bands(rng):
    one, two = band(rng, 3.0, 5.0), band(rng, 30.0, 34.0)
    loud = 3 * one * (np.abs(TIME - 10) < 2) + 3 * two * (np.abs(TIME - 45) < 2)
    (where,) = locate(traces(rng, {("imu1", "gyro", "y"): loud}), {})
    assert (where.at, list(where.channels)) == ("imu1", ["gyr_y"])
    centres = [np.mean(w) for w in where.windows_s]
    assert centres == pytest.approx([10, 45], abs=0.5)  # bins are 0.5 s
    assert [np.mean(b) for b in where.bands_hz] == pytest.approx([4, 32], abs=0.7)  # filter skirts


def test_excess_that_is_everywhere_gives_one_window_and_one_band(rng):
    (where,) = locate(traces(rng, {("imu1", "accel", "y"): 2 * rng.normal(size=TIME.size)}), {})
    assert where.windows_s == ((TIME[0], TIME[-1]),)
    assert where.bands_hz[0] == pytest.approx((0.0, RATE / 2))


@pytest.mark.parametrize("name", list(swinging()))
def test_what_the_excess_goes_with_is_named(rng, name):
    motion = swinging()
    size = motion[name] / np.sqrt(np.mean(motion[name] ** 2))
    loud = {("imu2", "accel", axis): 3 * size * band(rng, 5.0, 30.0) for axis in AXES}
    (where,) = locate(traces(rng, loud), everywhere(motion))
    assert where.depends_on == name


def test_shares_of_two_sensors_add_up_and_the_larger_comes_first(rng):
    loud = {("imu1", "gyro", "x"): band(rng, 5, 9), ("imu2", "gyro", "x"): 2 * band(rng, 5, 9)}
    first, second = locate(traces(rng, loud), {})
    assert (first.at, second.at) == ("imu2", "imu1")
    assert first.share + second.share == pytest.approx(1.0, abs=1e-9)  # shares of one sum
    assert first.share == pytest.approx(0.8, abs=0.05)  # 2^2 of 1 + 2^2, scatter of narrow bands 4 %


def test_gaps_and_a_clock_that_starts_late_do_no_harm(rng):
    time = 1000.0 + TIME[(TIME < 12) | (TIME > 15)]
    burst = 5 * rng.normal(size=time.size) * ((time > 1040) & (time < 1042))
    (where,) = locate(traces(rng, {("imu1", "accel", "z"): burst}, time), {})
    assert where.windows_s[0] == pytest.approx((1040, 1042), abs=0.51)  # bins are 0.5 s


def test_spectrum_of_white_noise_is_flat_and_a_tone_keeps_its_power(rng):
    f, density = spectrum(TIME, rng.normal(size=(TIME.size, 1)))
    # 29 half-overlapped windows: each value scatters by about 22 %, their mean over 200 by 2 %
    assert density.mean() == pytest.approx(2 / RATE, rel=0.06)
    f, density = spectrum(TIME, np.sin(2 * np.pi * 12.5 * TIME)[:, None])
    assert f[np.argmax(density)] == pytest.approx(12.5)
    assert density.sum() * f[1] == pytest.approx(0.5, rel=1e-3)  # the power of a sine; Hann leaks 1e-4


def test_reversals_leave_small_wavering_out():
    rate = np.sin(2 * np.pi * 0.5 * TIME) + 0.02 * np.sin(2 * np.pi * 20 * TIME)
    bumps = reversals(TIME, rate)
    peaks = np.flatnonzero((bumps[1:-1] > bumps[:-2]) & (bumps[1:-1] >= bumps[2:]) & (bumps[1:-1] > 0.9))
    assert len(peaks) == 59  # zero crossings of 0.5 Hz in 60 s, the one at the start has nothing before it
    assert bumps[np.abs(TIME - 1.5) < 0.2].max() < 0.01


def test_a_rate_that_never_turns_has_no_reversal():
    assert not reversals(TIME, np.ones_like(TIME)).any()


def test_the_spectrum_sees_the_end_of_a_recording():
    time = np.arange(0.0, 13.5, 0.01)  # no whole number of half windows
    late = np.where(time > 12.5, np.sin(2 * np.pi * 12.5 * time), 0.0)[:, None]
    early = np.where((time > 6.0) & (time < 7.0), np.sin(2 * np.pi * 12.5 * time), 0.0)[:, None]
    (f, last), (_, first) = spectrum(time, late), spectrum(time, early)
    assert f[np.argmax(last)] == pytest.approx(12.5, abs=0.3)
    assert last.max() > 0.01 * first.max()  # a window weighs its ends by a fifth, and there is one of them


def test_what_findings_add_is_located_however_small_it_is(rng):
    """A simulation has no noise: a thirtieth of the sensor's is found, and nothing where nothing is added."""
    added = {("imu2", "gyro", "y"): 0.03 * band(rng, 5.0, 8.0)}
    plain = [replace(t, before=np.zeros_like(t.before)) for t in traces(rng)]
    told = []
    for trace in plain:
        values = np.array(trace.before)
        for i, axis in enumerate(AXES):
            values[:, i] += trace.noise * added.get((trace.at, trace.part, axis), 0.0)
        told.append(replace(trace, before=values))
    (found,) = locate(told, everywhere(swinging()), noise=0.0)
    assert (found.at, list(found.channels)) == ("imu2", ["gyr_y"])
    ((low, high),) = found.bands_hz
    assert 4.0 < low < 6.0 and 7.0 < high < 9.0  # Hz; bins of the spectrum are 0.25 Hz, the filter's flanks 1
    assert locate(plain, everywhere(swinging()), noise=0.0) == ()


def test_a_sensor_keeps_the_band_in_which_a_motion_cannot_follow(rng):
    added = (replace(WHERE, at="imu2", bands_hz=((0.1, 2.0),)), replace(WHERE, at="imu1", bands_hz=((0.1, 3.0),)))
    left = (replace(WHERE, at="imu2", channels={"gyr_x": 1.0}, bands_hz=((9.0, 12.0),)),)
    first, second = acting_in(added, left)
    assert (first.at, first.channels, first.bands_hz) == ("imu2", WHERE.channels, ((9.0, 12.0),))
    assert second == added[1]
