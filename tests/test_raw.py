"""Raw checks on a small simulator of its own (NumPy, nothing of the effects) and on real recordings."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from imubench.convert.broad import convert as convert_broad
from imubench.convert.diodem import convert as convert_diodem
from imubench.diagnosis.raw import check, check_encoder
from imubench.diagnosis.raw_grid import stretches
from imubench.diagnosis.raw_knocks import apart_from, stepped
from imubench.diagnosis.raw_noise import white_level
from imubench.diagnosis.raw_samples import lattice
from imubench.recording import Encoder, Imu

GYRO, ACCEL = 0.002, 0.02  # rad/s, m/s^2, usual noise per sample


def tempo(rng, t, rest):
    """A smooth s(t) whose speed goes from rest to rest: levels of 2 to 8 s, a share of them still."""
    speed, at, level = np.zeros(t.size), t[0], 0.0
    while at < t[-1]:
        new = 0.0 if rng.random() < rest and level > 0 else rng.uniform(0.4, 1.0)
        ramp, stay = rng.uniform(0.3, 1.0), rng.uniform(2.0, 8.0)
        u = np.clip((t - at) / ramp, 0, 1)
        speed = np.where(t >= at, level + (new - level) * u**4 * (35 - 84 * u + 70 * u**2 - 20 * u**3), speed)
        at, level = at + ramp + stay, new
    return np.concatenate([[0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(t))])


def waves(rng, s, band, size):
    """A random quantity of s, a sum of sines up to `band` Hz whose rates together have the RMS `size`."""
    f = np.exp(rng.uniform(np.log(min(0.2, band / 4)), np.log(band), 12))
    f[0] = band
    rate = rng.uniform(0.5, 1.5, 12) / (1 + (f / min(1.0, band)) ** 2) ** rng.uniform(0.2, 0.6)
    rate *= size * np.sqrt(2) / np.linalg.norm(rate)
    return np.sin(2 * np.pi * np.outer(s, f) + rng.uniform(0, 2 * np.pi, 12)) @ (rate / (2 * np.pi * f))


def truth(rng, t, band, rest, rate_rms, accel_rms):
    """Rate (n, 3) and specific force (n, 3) of a body that turns by three Euler angles and is pushed about."""
    s = tempo(rng, t, rest)
    dt = t[1] - t[0]
    a, b, c = (waves(rng, s, band, rate_rms) for _ in range(3))
    b = 0.8 * np.tanh(b / 0.8)
    da, db, dc = (np.gradient(x, dt) for x in (a, b, c))
    ca, sa, cb, sb, cc, sc = np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(c), np.sin(c)
    gyro = np.stack([da - dc * sb, db * ca + dc * cb * sa, dc * cb * ca - db * sa], axis=-1)  # R = Rz(c) Ry(b) Rx(a)
    R = np.array([
        [cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa],
        [sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa],
        [-sb, cb * sa, cb * ca],
    ])  # fmt: skip
    push = np.stack([np.gradient(waves(rng, s, band, accel_rms / (2 * np.pi * 2)), dt) for _ in range(3)])
    return gyro, np.einsum("ijn,in->nj", R, push + np.array([[0], [0], [9.81]]))


def imu(
    seed, rate=100.0, seconds=60.0, band=4.0, rest=0.2, rate_rms=1.5, accel_rms=2.0, colour=0.0, noise=1.0,
    declared=True, before=None, after=None,
):  # fmt: skip
    """A recording; `before` and `after` the noise change (rng, time, gyro, accel)."""
    rng = np.random.default_rng(seed)
    fine = 8  # points between samples, for the derivatives
    t = np.arange(round(seconds * rate) * fine) / (rate * fine)
    gyro, accel = (x[::fine].copy() for x in truth(rng, t, band, rest, rate_rms, accel_rms))
    time = t[::fine]
    if before:
        gyro, accel = before(rng, time, gyro, accel)
    for x, std in ((gyro, GYRO), (accel, ACCEL)):
        corner = rng.uniform(0.5, 5.0)
        keep = np.exp(-2 * np.pi * corner / rate)
        slow = lfilter([np.sqrt(1 - keep**2)], [1, -keep], rng.normal(size=x.shape), axis=0)
        x += noise * std * (rng.normal(size=x.shape) + np.sqrt(colour) * slow)
    if after:
        time, gyro, accel = after(rng, time, gyro, accel)
    said = {"gyro_noise_std": GYRO, "accel_noise_std": ACCEL} if declared else {}
    return Imu("imu1", time, gyro, accel, rate, **said)


def found(recording, effect):
    """The finding of that name; no other effect may be there."""
    findings = check(recording).findings
    assert [f.effect for f in findings] == [effect]
    return findings[0]


def effects(recording):
    return {f.effect for f in check(recording).findings}


def knocked(peak, times, length=0.03):
    """Half a sine of `peak` m/s^2, `length` s long, in random directions."""

    def add(rng, t, gyro, accel):
        for start in times:
            u = (t - start) / length
            d = rng.normal(size=3)
            accel = accel + np.outer(np.where((u > 0) & (u < 1), peak * np.sin(np.pi * u), 0.0), d / np.linalg.norm(d))
        return gyro, accel

    return add


def humming(amplitude, frequency):
    def add(rng, t, gyro, accel):
        phase = np.cumsum(0.05 * np.sqrt(t[1]) * rng.normal(size=t.size))  # a motor's wander
        return gyro, accel + np.outer(np.sin(2 * np.pi * frequency * t + phase), amplitude)

    return add


def dropping(fraction, mode):
    def lose(rng, t, gyro, accel):
        there = rng.uniform(size=t.size) >= fraction
        there[0] = True
        if mode == "missing":
            return t[there], gyro[there], accel[there]
        last = np.maximum.accumulate(np.where(there, np.arange(t.size), 0))
        return t, gyro[last], accel[last]

    return lose


def rounding(gyro_step, accel_step):
    def rounded(rng, t, gyro, accel):
        return (
            t,
            gyro_step * np.round(gyro / gyro_step) if gyro_step else gyro,
            accel_step * np.round(accel / accel_step) if accel_step else accel,
        )

    return rounded


def clipping(gyro_limit=np.inf, accel_limit=np.inf):
    return lambda rng, t, gyro, accel: (
        t,
        np.clip(gyro, -gyro_limit, gyro_limit),
        np.clip(accel, -accel_limit, accel_limit),
    )


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


@pytest.mark.parametrize("rate", [50.0, 100.0, 200.0])
@pytest.mark.parametrize("peak", [6.0, 40.0])
def test_knocks_are_found_at_their_times(rate, peak):
    times = [5.213, 12.671, 20.444, 31.018, 44.6]
    finding = found(imu(41, rate=rate, band=3.0, before=knocked(peak, times)), "impacts")
    found_times = finding.parameters["times"][0]
    assert found_times.shape == (5,)
    assert np.abs(found_times - times).max() < 0.01 + 1.5 / rate  # the first sample of a rising pulse


def test_knocks_are_left_out_and_nothing_else():
    times = [5.0, 20.0, 40.0]
    checks = check(imu(42, before=knocked(20.0, times)))
    at = np.arange(6000) / 100
    for mask in (checks.masks["imu1.accel"], checks.struck["imu1.gyro"]):
        assert all(mask[(at > t + 0.005) & (at < t + 0.025)].all() for t in times)
        assert not mask[np.abs(at[:, None] - times).min(axis=1) > 0.3].any()


@pytest.mark.parametrize("before_end", [0.1, 0.15, 0.3])
def test_a_knock_just_before_a_gap_is_left_out(before_end):
    """Left in, one of 33 m/s^2 made a slip and springs of the whole recording (213 of 300 unseen cases)."""

    def gap(rng, t, gyro, accel):
        keep = (t < 20.0 + before_end) | (t > 20.5)
        return t[keep], gyro[keep], accel[keep]

    checks = check(imu(42, band=4.0, before=knocked(20.0, [20.0, 30.0, 40.0]), after=gap))
    at = imu(42, after=gap).time
    (finding,) = (f for f in checks.findings if f.effect == "impacts")
    assert np.abs(finding.parameters["times"][0] - [20.0, 30.0, 40.0]).max() < 0.02
    assert checks.struck["imu1.accel"][(at > 20.005) & (at < 20.025)].all()


def test_a_knock_while_a_limb_is_let_go_is_heard_and_the_jerk_is_not():
    """A knock 0.1 s before a swing stayed in the fit, which then had something without a name (273 of 300 unseen)."""

    def let_go(rng, t, gyro, accel):
        kink = np.maximum(0.0, t - 30.0)[:, None] * np.exp(-np.maximum(0.0, t - 30.0) / 0.1)[:, None]
        gyro, accel = knocked(20.0, [20.0])(rng, t, gyro, accel)
        return gyro, accel + kink * [20.0, -5.0, 2.0]

    checks = check(imu(42, band=4.0, before=let_go), ((20.1, 25.0), (30.1, 35.0)))
    (finding,) = (f for f in checks.findings if f.effect == "impacts")
    assert finding.parameters["times"][0] == pytest.approx([20.0], abs=0.02)


def test_one_wild_sample_is_left_out_and_no_knock():
    def wild(rng, t, gyro, accel):
        accel[[1000, 3000], 1] += 5.0
        return t, gyro, accel

    checks = check(imu(43, after=wild))
    assert checks.findings == ()
    assert checks.masks["imu1.accel"][[1000, 3000]].all()


def test_a_limb_that_is_let_go_is_no_knock():
    def let_go(rng, t, gyro, accel):
        u = np.clip((t - 20) / 0.05, 0, 1)
        return gyro, accel + np.outer(u**2 * (3 - 2 * u), [4.0, -1.0, 0.5])

    assert effects(imu(44, band=2.0, before=let_go)) == set()


@pytest.mark.parametrize(
    ("rate", "frequency"), [(50.0, 19.3), (100.0, 15.2), (100.0, 41.7), (200.0, 77.0), (100.0, 130.0)]
)
@pytest.mark.parametrize("size", [0.03, 0.5])
def test_a_hum_is_found_with_its_frequency_and_amplitude(rate, frequency, size):
    amplitude = size * np.array([0.8, -0.6, 0.0])
    finding = found(imu(51, rate=rate, before=humming(amplitude, frequency)), "vibration")
    image = abs(frequency - rate * round(frequency / rate))
    value, std, _ = finding.parameters["frequency"]
    assert abs(value - image) < max(4 * std, 0.03)  # a tenth of the windows' resolution
    size_found = finding.parameters["amplitude"][0]
    error = min(np.linalg.norm(size_found - amplitude), np.linalg.norm(size_found + amplitude))
    assert error < 0.1 * size + 0.006  # noise of 0.02 in 100 samples: 0.003 for each of cosine and sine


def test_a_hum_is_found_where_lost_samples_leave_three_windows():
    whole = imu(51, seconds=14.4, before=humming(np.array([0.3, -0.2, 0.5]), 22.0))
    keep = (np.abs(whole.time - 5.0) > 0.05) & (np.abs(whole.time - 9.5) > 0.05)  # one window of 4 s in each piece
    short = replace(whole, time=whole.time[:850], gyro=whole.gyro[:850], accel=whole.accel[:850])
    broken = replace(whole, time=whole.time[keep], gyro=whole.gyro[keep], accel=whole.accel[keep])
    for recording in (short, broken):
        assert abs(found(recording, "vibration").parameters["frequency"][0] - 22.0) < 0.05


def test_three_windows_of_noise_have_no_hum():
    rng = np.random.default_rng(7)
    for seed in range(40):
        whole = imu(seed, seconds=9.0, colour=0.2 * rng.random())
        keep = rng.random(whole.time.size) > 0.3 * (seed % 2)
        kept = replace(whole, time=whole.time[keep], gyro=whole.gyro[keep], accel=whole.accel[keep])
        assert "vibration" not in effects(kept)


def test_a_hum_above_a_slow_motion_is_found_and_a_hand_that_shakes_is_none():
    slow = imu(53, band=1.0, rate_rms=0.5, accel_rms=0.5, before=humming(np.array([0.3, 0, 0]), 8.5))
    assert abs(found(slow, "vibration").parameters["frequency"][0] - 8.5) < 0.03

    def shaking(rng, t, gyro, accel):
        turn, rate = 0.05 * np.sin(2 * np.pi * 9.0 * t), 0.05 * 2 * np.pi * 9.0 * np.cos(2 * np.pi * 9.0 * t)
        force = [-9.81 * np.sin(turn) - 0.2 * rate**2, 0 * t, 9.81 * np.cos(turn) - 0.2 * (18 * np.pi) ** 2 * turn]
        return np.stack([0 * t, rate, 0 * t], axis=1), np.stack(force, axis=1)  # a line at 9 Hz, and one at 18

    assert effects(imu(54, before=shaking)) == set()


def test_a_resonance_is_no_hum():
    """A mount at 14 Hz, damped by 0.1, that the motion and tremor shake."""

    def rocking(rng, t, gyro, accel):
        w, z, dt = 2 * np.pi * 14.0, 0.1, t[1]
        r = np.exp(-z * w * dt)
        shaken = lfilter(
            [1], [1, -2 * r * np.cos(w * dt * np.sqrt(1 - z**2)), r**2], rng.normal(size=accel.shape), axis=0
        )
        return gyro, accel + 0.3 * shaken / shaken.std()

    assert "vibration" not in effects(imu(52, before=rocking))


@pytest.mark.parametrize("factor", [1.5, 2.5, 5.0])
@pytest.mark.parametrize("part", ["gyro", "accel"])
def test_noise_above_the_declared_is_found_with_its_level(part, factor):
    std = {"gyro": GYRO, "accel": ACCEL}

    def louder(rng, t, gyro, accel):
        extra = np.sqrt(factor**2 - 1) * std[part]
        both = {"gyro": gyro, "accel": accel}
        both[part] = both[part] + extra * rng.normal(size=gyro.shape)
        return t, both["gyro"], both["accel"]

    finding = found(imu(61, colour=0.2, after=louder), f"{part}_noise")
    value, error, _ = finding.parameters["std"]
    # the coloured noise's tail above 12 Hz adds up to 2 % of power to the usual level
    assert abs(value - factor * std[part]) < 4 * error + 0.02 * std[part]


def test_the_noise_levels_error_is_what_it_says():
    z = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        time, none = np.arange(2000) / 100, np.zeros(2000, dtype=bool)
        pieces = stretches(time, rng.normal(size=(2000, 3)), rng.normal(size=(2000, 3)), none)
        level = white_level(pieces, "gyro", 100.0, none)
        z.append((level.std - 1) / level.error)
    assert 0.7 < np.sqrt(np.mean(np.square(z))) < 1.3  # forty draws: 11 % of error, and a tenth for the formula


def test_rattling_that_comes_and_goes_is_no_noise():
    """A dead band or play is rough in motion and quiet at rest; a sensor's noise is there all the time."""

    def rattle(rng, t, gyro, accel):
        moving = np.abs(np.sin(0.2 * t))[:, None] ** 2
        return gyro + 0.02 * moving * rng.normal(size=gyro.shape), accel

    assert effects(imu(63, before=rattle)) == set()


def test_fast_motion_is_no_noise():
    """Motion that fades slowly towards the highest frequencies, as a hand's real motion does at 40 Hz."""

    def tremor(rng, t, gyro, accel):
        slow = lfilter([0.2], [1, -0.8], rng.normal(size=gyro.shape), axis=0)
        return gyro + 0.05 * lfilter([0.2], [1, -0.8], slow, axis=0), accel + 0.5 * lfilter(
            [0.2], [1, -0.8], slow, axis=0
        )

    assert effects(imu(62, rate=50.0, rest=0.0, before=tremor)) == set()


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


def test_knocks_alike_need_no_tail_to_stand_out_of_but_a_tail_hides_them():
    alike = np.array([20.3, 15.6, 25.2, 17.2])
    assert (alike > apart_from(alike)).all()
    bumps = np.array([4.2, 4.5, 5.0, 5.5, 6.0, 7.0])
    assert not (alike > apart_from(np.concatenate([alike, bumps]))).any()
    one = np.array([17.2])
    assert not (one > apart_from(one)).any()


@pytest.mark.parametrize("slope", [0.0, 20.0])
def test_a_knock_on_a_ramp_is_no_step(slope):
    time = np.arange(0, 1, 0.01)
    accel = slope * time[:, None] * np.array([1.0, -0.5, 0.2])
    knocked = accel.copy()
    knocked[50:52] += [0.6, 0.3, 0.0]
    assert not stepped(knocked, 50, 100.0)
    assert stepped(accel + 0.6 * (time >= 0.5)[:, None], 50, 100.0)
