"""The profiles as data: their numbers in SI, their sources, and what a broken file is told."""

import tomllib
from importlib.resources import files
from math import pi, sqrt

import numpy as np
import pytest

from imubench.errors import InputError
from imubench.sim.imu_model import observe_imu
from imubench.sim.profiles import PROFILES, UNITS, load_profiles, parse_profiles, profile
from imubench.truth import SensorTruth

NAMES = ("perfect", "xsens_mtw", "xsens_mtw_awinda", "xsens_mtw_awinda_paper_deg", "mpu9250")
G = 9.80665


def still(count, rate):
    rest, zero = np.tile([0, 0, 9.81], (count, 1)), np.zeros((count, 3))
    quaternion = np.tile([1.0, 0, 0, 0], (count, 1))
    sensor = SensorTruth("imu1", zero, quaternion, zero, zero, rest, zero, zero, None, zero, zero)
    return sensor, np.arange(count) / rate


def parse(text):
    return parse_profiles(text.encode(), "mine.toml")


RATE = 'rate = { value = 50, unit = "Hz", source = "sheet" }\n'


def test_the_profiles_of_both_papers_a_consumer_part_and_a_perfect_one_are_there():
    assert tuple(PROFILES) == NAMES
    assert all(p.summary and chr(10) not in p.summary for p in PROFILES.values())


@pytest.mark.parametrize("name", NAMES)
def test_every_number_names_its_source(name):
    table = tomllib.loads((files("imubench.sim") / "profiles.toml").read_text())[name]
    numbers = {key for key in table if key in UNITS[""]}
    numbers |= {f"{kind}.{key}" for kind in ("gyro", "accel") for key in table.get(kind, {})}
    sources = profile(name).sources
    assert set(sources) == numbers
    assert all(len(source) > 5 for source in sources.values())
    for key, source in sources.items():
        if source.startswith("not in the datasheet"):
            assert "taken as" in source, key


@pytest.mark.parametrize("name", NAMES)
def test_every_profile_makes_a_recording_with_the_noise_it_declares(name):
    p = profile(name)
    sensor, time = still(20_000, p.rate)
    got = observe_imu(sensor, time, p, np.random.default_rng(1))
    for reading, declared in ((got.gyro, got.gyro_noise_std), (got.accel, got.accel_noise_std)):
        # from second differences, so that a slow bias does not count; white noise: variance 6 std^2.
        # 60,000 samples: 0.6 %; the MPU's noise is not quite white (0.3 %)
        measured = np.diff(reading, n=2, axis=0).std() / sqrt(6)
        assert measured == pytest.approx(declared, rel=0.02, abs=1e-15)


def test_perfect_is_perfect():
    p = profile("perfect")
    sensor, time = still(100, p.rate)
    got = observe_imu(sensor, time, p, np.random.default_rng(0))
    assert np.array_equal(got.gyro, sensor.gyro)
    assert np.array_equal(got.accel, sensor.specific_force)
    assert (got.gyro_noise_std, got.accel_noise_std, got.gyro_range, got.accel_range) == (0.0, 0.0, None, None)


def test_the_mtw_has_the_ranges_rate_and_bias_of_the_first_paper():
    p = profile("xsens_mtw")
    assert (p.rate, p.gyro.range, p.accel.range) == (50.0, 21.0, 160.0)
    # |b| = 0.5 deg/s and 0.1 m/s^2 in the paper, written to three digits per axis
    assert p.gyro.bias_std * sqrt(3) == pytest.approx(0.5 * pi / 180, rel=2e-3)
    assert p.accel.bias_std * sqrt(3) == pytest.approx(0.1, rel=2e-3)
    assert p.gyro.sample_noise_std(50.0) == pytest.approx(0.05 * pi / 180 * 5, rel=1e-12)
    assert p.accel.sample_noise_std(50.0) == pytest.approx(0.003 * 5, rel=1e-12)


def test_the_second_papers_gyro_noise_fits_its_datasheet_in_rad_per_second_only():
    default, to_the_letter = profile("xsens_mtw_awinda"), profile("xsens_mtw_awinda_paper_deg")
    from_sheet_gyro = 0.01 * pi / 180 * sqrt(100)  # rad/s
    from_sheet_accel = 200e-6 * G * sqrt(100)  # m/s^2
    # the paper prints two digits of the gyro's and one of the accelerometer's: 0.0017 and 0.02
    assert round(from_sheet_gyro, 4) == default.gyro.noise_std == 0.0017
    assert round(from_sheet_accel, 2) == default.accel.noise_std == 0.02
    assert to_the_letter.gyro.noise_std == pytest.approx(0.0017 * pi / 180, rel=1e-12)
    assert from_sheet_gyro / to_the_letter.gyro.noise_std > 50  # the other reading is far off
    assert default.rate == to_the_letter.rate == 100.0


def test_the_two_readings_differ_in_nothing_else():
    one, other = (profile(name) for name in ("xsens_mtw_awinda", "xsens_mtw_awinda_paper_deg"))
    for kind in ("gyro", "accel"):
        a, b = vars(getattr(one, kind)), vars(getattr(other, kind))
        assert [k for k in a if not np.array_equal(a[k], b[k])] == (["noise_std"] if kind == "gyro" else [])


def test_the_consumer_part_in_si():
    p = profile("mpu9250")
    assert p.gyro.range == pytest.approx(34.906585, rel=1e-7)
    assert p.accel.range == pytest.approx(16 * G, rel=1e-12)
    assert p.gyro.step == pytest.approx(pi / 180 / 16.4, rel=1e-12)
    assert p.accel.step == pytest.approx(G / 2048, rel=1e-12)
    assert p.gyro.noise_density == pytest.approx(1.7453293e-4, rel=1e-7)
    assert p.accel.noise_density == pytest.approx(300e-6 * G, rel=1e-12)
    assert p.gyro.bias_instability == pytest.approx(10 * pi / 180 / 3600, rel=1e-12)
    assert np.allclose(p.g_sensitivity, 0.1 * pi / 180 / G * np.eye(3), rtol=1e-12)
    # three standard deviations are the datasheet's tolerances, written to three or four digits
    assert 3 * p.gyro.bias_std == pytest.approx(5 * pi / 180, rel=1e-3)
    assert 3 * p.accel.bias_std == pytest.approx(0.0666 * G, rel=1e-3)
    assert 3 * p.gyro.scale_std == pytest.approx(0.03, rel=1e-12)
    assert 3 * p.gyro.misalignment_std == pytest.approx(0.02, rel=1e-4)


def test_the_noise_model_meets_the_datasheets_total_rms_of_the_gyro():
    # PS-MPU-9250A-01, table 1: 0.1 deg/s-rms at 92 Hz. The sheet rounds, and a first-order filter passes
    # pi/2 of the noise power of a brick wall: between 1 and sqrt(pi/2)
    p = profile("mpu9250")
    ratio = p.gyro.sample_noise_std(100.0) / (0.1 * pi / 180)
    assert 1.0 < ratio < sqrt(pi / 2)


# --- bad input ---------------------------------------------------------------------------------------------


def test_an_unknown_profile_is_told_the_known_ones():
    with pytest.raises(
        InputError, match=rf"^unknown IMU profile 'xsens'; known: {', '.join(NAMES)}; did you mean 'xsens_mtw'\?$"
    ):
        profile("xsens")


def test_a_table_is_all_a_new_profile_needs(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(f'[mine]\n{RATE}[mine.gyro]\nbias = {{ value = [1, 2, 3], unit = "deg/s", source = "me" }}\n')
    (mine,) = load_profiles(path).values()
    assert (mine.name, mine.rate, mine.sources["gyro.bias"]) == ("mine", 50.0, "me")
    assert np.allclose(mine.gyro.bias, np.array([1, 2, 3]) * pi / 180, rtol=1e-12)


BROKEN = {
    "an unknown key": (
        f'[p]\n{RATE}colour = "red"',
        r"unknown key in mine\.toml: p 'colour'; known: rate, g_sensitivity, .*",
    ),
    "an unknown key of a channel": (
        f'[p]\n{RATE}[p.gyro]\nnoise = {{ value = 1, unit = "deg/s", source = "s" }}',
        r"unknown key in mine\.toml: p\.gyro 'noise'; known: noise_density, .*",
    ),
    "an unknown key of a number": (
        '[p]\nrate = { value = 1, unit = "Hz", sauce = "s" }',
        r"unknown key in mine\.toml: p\.rate 'sauce'; known: value, unit, source, note; did you mean 'source'\?",
    ),
    "an unknown unit": (
        f'[p]\n{RATE}[p.gyro]\nnoise_density = {{ value = 1, unit = "deg/s", source = "s" }}',
        r"unknown unit of mine\.toml: p\.gyro\.noise_density 'deg/s'; known: rad/s/sqrt\(Hz\), .*",
    ),
    "no unit": (
        '[p]\nrate = { value = 1, source = "s" }',
        r"mine\.toml: p\.rate\.unit: expected a text, got None",
    ),
    "no source": (
        '[p]\nrate = { value = 1, unit = "Hz", source = " " }',
        r"mine\.toml: p\.rate\.source: expected a text, got ' '",
    ),
    "a note that is no text": (
        '[p]\nrate = { value = 1, unit = "Hz", source = "s", note = 3 }',
        r"mine\.toml: p\.rate\.note: expected a text, got 3",
    ),
    "no value": (
        '[p]\nrate = { unit = "Hz", source = "s" }',
        r"mine\.toml: p\.rate\.value: expected .*",
    ),
    "a value that is no number": (
        '[p]\nrate = { value = "fast", unit = "Hz", source = "s" }',
        r"mine\.toml: p\.rate\.value: expected a number or a list of them, got 'fast'",
    ),
    "NaN": (
        '[p]\nrate = { value = nan, unit = "Hz", source = "s" }',
        r"mine\.toml, key 'p\.rate\.value': expected a finite number, got nan",
    ),
    "a bare number": ("[p]\nrate = 100", r"mine\.toml: p\.rate: expected a table, got 100"),
    "no rate": ('[p]\nsummary = "x"', r"mine\.toml: p\.rate: expected a rate, got none"),
    "no table": ("p = 3", r"mine\.toml: p: expected a table, got 3"),
    "a summary that is no text": (
        f"[p]\n{RATE}summary = 3",
        r"mine\.toml: p\.summary: expected a text, got 3",
    ),
    "a negative noise": (
        f'[p]\n{RATE}[p.accel]\nnoise_std = {{ value = -1, unit = "mg", source = "s" }}',
        r"mine\.toml: p: accel: noise_std: expected a number >= 0, got -0\.009.*",
    ),
    "a list where a number belongs": (
        '[p]\nrate = { value = [1, 2], unit = "Hz", source = "s" }',
        r"mine\.toml: p: profile p\.rate: expected a number > 0, got array.*",
    ),
    "an unknown drop-out mode": (
        f'[p]\n{RATE}dropout_mode = "lost"',
        r"mine\.toml: p: unknown dropout_mode 'lost'; known: missing, held",
    ),
    "no TOML": ("[p\nrate", r"mine\.toml: expected TOML, got: .*"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_file_is_told_what_is_wrong_in_one_line(case):
    text, message = BROKEN[case]
    with pytest.raises(InputError, match=f"^{message}$") as caught:
        parse(text)
    assert "\n" not in str(caught.value)


def test_not_utf8():
    with pytest.raises(InputError, match=r"^mine\.toml, line 2: expected UTF-8 text, got byte 0xff$"):
        parse_profiles(b"[p]\n# \xff", "mine.toml")


def test_a_missing_file(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: expected a file, got nothing of that name$"):
        load_profiles(tmp_path / "none.toml")
