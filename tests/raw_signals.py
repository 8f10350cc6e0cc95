"""IMU readings from a small simulator of its own (NumPy, nothing of the effects), and what may be wrong with them."""

import numpy as np
from scipy.signal import lfilter

from imubench.diagnosis.samples.checks import check
from imubench.recording import Imu

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
