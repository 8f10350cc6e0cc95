"""What an IMU makes of the true motion of its sensing element.

In this order: the parallel errors y = x + M x + s.x + A f + b on the true signal; the low-pass filter, as a device's
own; the reading at world time (stamp - offset) / (1 + skew); drift, hum and knocks; noise; the clip at `limit`; the
rounding to `step`; lost samples. M = the `matrix` of a misalignment, xy xz yx yz zx zy, entry ij multiplies input j.

    drift      rate * (time since the first stamp)       hum    amplitude sin(2 pi frequency t + phase), slow phase
    knock      peak direction exp(-s / 15 ms) sin(2 pi 30 Hz s), s the time since; 3 % of it in rad/s on the gyro
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from imubench.proof.frames import STEP, Track, read_at
from imubench.proof.options import CORNERS, Effect, Options, find, stream
from imubench.proof.rotation import Array
from imubench.proof.unknown import on_the_samples, on_the_signal

CHANNELS = ("gyro", "accel")
OFF_DIAGONAL = ((0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1))
KNOCK_DECAY, KNOCK_FREQUENCY, KNOCK_GYRO = 0.015, 30.0, 0.03  # s, Hz, rad/s per m/s^2
HUM_WANDER = 0.05  # rad per root second, of the hum's phase


@dataclass(frozen=True)
class Samples:
    """What one IMU recorded: stamps (m,) s, gyro and accel (m, 3)."""

    time: Array
    gyro: Array
    accel: Array


def stamps(rng: np.random.Generator, seconds: float, rate: float) -> Array:
    """Return the stamps (m,) of an IMU's own clock: up to 0.3 % off its rate, starting when it likes."""
    real = rate * (1 + rng.uniform(-0.003, 0.003))
    return np.arange(rng.uniform(0, 1 / rate), seconds, 1 / real)


def world_time(time: Array, at: str, effects: list[Effect]) -> Array:
    """Return the world's time (m,) at an IMU's stamps."""
    offset, skew = find(effects, "time_offset", at), find(effects, "clock_skew", at)
    return (time - (float(offset["offset"]) if offset else 0.0)) / (1 + (float(skew["skew"]) if skew else 0.0))


def read_imu(track: Track, at: str, effects: list[Effect], options: Options, rate: float, seed: int) -> Samples:
    """Return the samples of one IMU whose sensing element moves along `track`."""
    time = stamps(stream(seed, f"clock {at}"), options.seconds, rate)
    there = world_time(time, at, effects)
    true = {"gyro": track.w, "accel": track.f}
    extra = on_the_signal(at, effects, true)
    samples = {}
    for channel in CHANNELS:
        signal = true[channel] + extra[channel] + parallel_errors(channel, at, effects, true)
        cutoff = _cutoff(channel, at, effects)
        if cutoff:
            signal = low_passed(signal, cutoff)
        x = read_at(there, signal)
        if drift := find(effects, f"{channel}_drift", at):
            x = x + np.outer(time - time[0], np.asarray(drift["rate"], dtype=float))
        if channel == "accel" and (hum := find(effects, "vibration", at)):
            x = x + humming(there, hum, cutoff, stream(seed, f"hum {at}"))
        if knocks := find(effects, "impacts", at):
            x = x + knocking(time, knocks, channel, stream(seed, f"knocks {at}"))
        x = x + on_the_samples(at, effects, time, channel, stream(seed, f"walk {at} {channel}"))
        x = x + noise(len(time), channel, at, effects, options, rate, stream(seed, f"noise {at} {channel}"))
        samples[channel] = digitised(x, channel, at, effects)
    return lost(Samples(time, samples["gyro"], samples["accel"]), at, effects, options, stream(seed, f"lost {at}"))


def parallel_errors(channel: str, at: str, effects: list[Effect], true: dict[str, Array]) -> Array:
    """Return M x + s.x + A f + b (n, 3)."""
    x = true[channel]
    M, b = np.zeros((3, 3)), np.zeros(3)
    if p := find(effects, f"{channel}_scale", at):
        M += np.diag(np.asarray(p["scale"], dtype=float))
    if p := find(effects, f"{channel}_misalignment", at):
        for (i, j), value in zip(OFF_DIAGONAL, p["matrix"], strict=True):
            M[i, j] += value
    if p := find(effects, f"{channel}_bias", at):
        b = np.asarray(p["bias"], dtype=float)
    error = x @ M.T + b
    if channel == "gyro" and (p := find(effects, "g_sensitivity", at)):
        error = error + true["accel"] @ np.asarray(p["matrix"], dtype=float).T
    return error


def low_passed(x: Array, cutoff: float) -> Array:
    """Return y (n, 3) of y' = 2 pi cutoff (x - y), exact for x linear between grid points, settled at the start."""
    a = 2 * np.pi * cutoff * STEP
    e = np.exp(-a)
    first, last = (1 - e) / a - e, 1 - (1 - e) / a  # weights of the interval's two ends
    return np.asarray(lfilter([last, first], [1, -e], x - x[0], axis=0)) + x[0]


def humming(time: Array, hum: dict[str, object], cutoff: float, rng: np.random.Generator) -> Array:
    """Return the hum (m, 3) at world times, behind the low-pass filter where there is one."""
    frequency = float(hum["frequency"])  # type: ignore[arg-type]
    answer = 1 / (1 + 1j * frequency / cutoff) if cutoff else 1.0
    wander = np.cumsum(HUM_WANDER * np.sqrt(np.diff(time, prepend=time[0])) * rng.standard_normal(len(time)))
    phase = 2 * np.pi * frequency * time + rng.uniform(0, 2 * np.pi) + wander + np.angle(answer)
    return np.outer(np.abs(answer) * np.sin(phase), np.asarray(hum["amplitude"], dtype=float))


def knocking(time: Array, knocks: dict[str, object], channel: str, rng: np.random.Generator) -> Array:
    """Return the knocks (m, 3) on one channel; each has its own direction and strength around `peak` m/s^2."""
    total = np.zeros((len(time), 3))
    for start in knocks["times"]:  # type: ignore[attr-defined]
        push, turn = rng.standard_normal((2, 3))
        size = float(knocks.get("peak", 40.0)) * rng.uniform(0.7, 1.4)  # type: ignore[arg-type]
        s = np.maximum(time - float(start), 0)
        ring = 1.5 * size * np.exp(-s / KNOCK_DECAY) * np.sin(2 * np.pi * KNOCK_FREQUENCY * s)
        direction = push / np.linalg.norm(push) if channel == "accel" else KNOCK_GYRO * turn / np.linalg.norm(turn)
        total += np.outer(ring, direction)
    return total


def noise_std(channel: str, at: str, effects: list[Effect], options: Options) -> tuple[float, float]:
    """Return the white noise's std per sample as it is, and without the effect `gyro_noise` or `accel_noise`."""
    usual = options.noise * (options.gyro_noise if channel == "gyro" else options.accel_noise)
    p = find(effects, f"{channel}_noise", at)
    return (float(p["std"]) if p else usual), usual


def noise(
    m: int, channel: str, at: str, effects: list[Effect], options: Options, rate: float, rng: np.random.Generator
) -> Array:
    """Return white noise, and coloured noise (first order, 0.5 to 5 Hz) of `colour` times its usual power."""
    std, usual = noise_std(channel, at, effects, options)
    white, drive, keep = _drawn(m, rate, rng, options.corner)
    drive[1:] *= np.sqrt(1 - keep**2)
    return std * white + usual * np.sqrt(options.colour) * np.asarray(lfilter([1.0], [1.0, -keep], drive, axis=0))


def _drawn(m: int, rate: float, rng: np.random.Generator, corner: float | None) -> tuple[Array, Array, float]:
    """Return two white noises (m, 3) of std 1, and how much of the coloured one is left after a sample."""
    white, drive, drawn = rng.standard_normal((m, 3)), rng.standard_normal((m, 3)), rng.uniform(*CORNERS)
    return white, drive, float(np.exp(-2 * np.pi * (drawn if corner is None else corner) / rate))


def kept(m: int, channel: str, at: str, rate: float, seed: int, corner: float | None = None) -> float:
    """Return how much of a channel's coloured noise is left after a sample, of m samples."""
    return _drawn(m, rate, stream(seed, f"noise {at} {channel}"), corner)[2]


def _cutoff(channel: str, at: str, effects: list[Effect]) -> float:
    p = find(effects, "low_pass", at)
    return float(p["cutoff"]) if p and channel in p.get("channels", CHANNELS) else 0.0


def digitised(x: Array, channel: str, at: str, effects: list[Effect]) -> Array:
    """Return x (m, 3) clipped at `limit` and rounded to `step`."""
    p = find(effects, "saturation", at)
    if p and channel in p["channels"]:
        x = np.clip(x, -float(p["limit"]), float(p["limit"]))
    p = find(effects, "quantisation", at)
    if p and channel in p["channels"]:
        x = float(p["step"]) * np.round(x / float(p["step"]))
    return x


def lost(samples: Samples, at: str, effects: list[Effect], options: Options, rng: np.random.Generator) -> Samples:
    """Return the samples without those of gaps and dropouts; a held or repeated one says the last one again."""
    m = len(samples.time)
    missing, held = np.zeros(m, dtype=bool), np.zeros(m, dtype=bool)
    for _ in range(options.gaps):
        start = rng.uniform(0.05, 0.9) * options.seconds
        missing |= (samples.time > start) & (samples.time < start + rng.uniform(0.05, 0.3))
    held[rng.choice(np.arange(2, m), options.repeats, replace=False)] = True
    if p := find(effects, "dropouts", at):
        drops = rng.random(m) < float(p["fraction"])
        (held if p["mode"] == "held" else missing)[1:] |= drops[1:]
    source = np.maximum.accumulate(np.where(held, 0, np.arange(m)))
    keep = ~missing
    return Samples(samples.time[keep], samples.gyro[source][keep], samples.accel[source][keep])
