"""Random motion of a hand: band-limited, never periodic, with pauses, and with exact derivatives.

A quantity is x(t) = x0 + sum_m a_m cos(2 pi f_m s(t) + phi_m) with random f_m, phi_m, and s(t) a smooth tempo common
to all quantities of a rig: ds/dt goes from 0 (a rest, in whatever pose) to 1. So x'' = x_ss s'^2 + x_s s''.
"""

from dataclasses import dataclass

import numpy as np

from imubench.proof.rotation import Array


def smooth_step(x: Array) -> tuple[Array, Array, Array, Array]:
    """Return the step 0 -> 1 over 0 <= x <= 1 with three zero derivatives at either end: integral, it, 1st, 2nd."""
    y = np.clip(x, 0.0, 1.0)
    integral = y**5 * (7 - 14 * y + 10 * y**2 - 2.5 * y**3) + np.maximum(x - 1, 0)
    return (
        integral,
        y**4 * (35 - 84 * y + 70 * y**2 - 20 * y**3),
        140 * (y * (1 - y)) ** 3,
        420 * (y * (1 - y)) ** 2 * (1 - 2 * y),
    )


@dataclass(frozen=True)
class Tempo:
    """s(t) with its first two derivatives, (n,) each."""

    s: Array
    s1: Array
    s2: Array


def random_tempo(rng: np.random.Generator, t: Array, rest: float) -> Tempo:
    """Return a tempo over t (n,): levels of 2 to 9 s, of which a share `rest` stands still.

    `rest` = 1 stands still for ever, 0 always moves.
    """
    if rest >= 1:
        return Tempo(0 * t, 0 * t, 0 * t)
    start, level = t[0], 0.0 if rest > 0 else 0.5
    s, s1, s2 = level * (t - start), np.full_like(t, level), 0 * t
    at = start + rng.uniform(1.0, 3.0)
    while at < t[-1]:
        new = 0.0 if rng.random() < rest and level > 0 else rng.uniform(0.5, 1.0)
        ramp = rng.uniform(0.4, 1.2)
        integral, step, slope, _ = smooth_step((t - at) / ramp)
        s, s1, s2 = s + (new - level) * ramp * integral, s1 + (new - level) * step, s2 + (new - level) * slope / ramp
        level = new
        at += ramp + (rng.uniform(0.8, 3.0) if level == 0 else rng.uniform(2.0, 9.0))
    return Tempo(s, s1, s2)


def steady(t: Array) -> Tempo:
    """Return the tempo of a clock."""
    return Tempo(t, np.ones_like(t), np.zeros_like(t))


@dataclass(frozen=True)
class Wave:
    """A random quantity: frequencies (m,) Hz, amplitudes (m,), phases (m,) rad and a centre."""

    frequency: Array
    amplitude: Array
    phase: Array
    centre: float = 0.0

    def along(self, tempo: Tempo) -> tuple[Array, Array, Array]:
        """Return the value and its first two derivatives in time, (n,) each."""
        x, x_s, x_ss = np.full_like(tempo.s, self.centre), 0 * tempo.s, 0 * tempo.s
        for frequency, amplitude, phase in zip(self.frequency, self.amplitude, self.phase, strict=True):
            rate = 2 * np.pi * frequency
            angle = rate * tempo.s + phase
            cosine = amplitude * np.cos(angle)
            x += cosine
            x_s -= amplitude * rate * np.sin(angle)
            x_ss -= rate**2 * cosine
        return x, x_s * tempo.s1, x_ss * tempo.s1**2 + x_s * tempo.s2


def angle_wave(
    rng: np.random.Generator, band: float, rate_rms: float, largest: float, centre: float = 0.0, terms: int = 14
) -> Wave:
    """Return a random angle whose rate is flat to a corner of 0.4 to 1.5 Hz and falls from there to `band` Hz.

    `rate_rms` rad/s at full tempo; no excursion beyond about `largest` rad.
    """
    frequency = np.exp(rng.uniform(np.log(min(0.15, band / 4)), np.log(band), terms))
    frequency[0] = band  # the band is reached
    corner = min(rng.uniform(0.4, 1.5), band)
    rate = rng.uniform(0.5, 1.5, terms) / (1 + (frequency / corner) ** 2) ** 0.55
    rate *= rate_rms * np.sqrt(2 / (rate**2).sum())
    amplitude = rate / (2 * np.pi * frequency)
    amplitude = np.minimum(amplitude, largest / 2.5)
    amplitude *= min(1.0, largest / (0.6 * amplitude.sum()))
    return Wave(frequency, amplitude, rng.uniform(0, 2 * np.pi, terms), centre)


def place_wave(rng: np.random.Generator, band: float, accel_rms: float, terms: int = 12) -> Wave:
    """Return a random coordinate in m whose acceleration has `accel_rms` m/s^2 at full tempo, within about 0.6 m."""
    frequency = np.exp(rng.uniform(np.log(min(0.3, band / 3)), np.log(band), terms))
    accel = rng.uniform(0.5, 1.5, terms) / (1 + (frequency / min(2.0, band)) ** 2) ** 0.5
    accel *= accel_rms * np.sqrt(2 / (accel**2).sum())
    return Wave(frequency, np.minimum(accel / (2 * np.pi * frequency) ** 2, 0.3), rng.uniform(0, 2 * np.pi, terms))


def band_noise(rng: np.random.Generator, band: tuple[float, float], std: float, terms: int = 40) -> Wave:
    """Return a stationary quantity of standard deviation `std` with its power even over `band` Hz."""
    edges = np.linspace(band[0], band[1], terms + 1)
    frequency = rng.uniform(edges[:-1], edges[1:])
    amplitude = np.abs(rng.standard_normal(terms)) + 0.3
    amplitude *= std * np.sqrt(2 / (amplitude**2).sum())
    return Wave(frequency, amplitude, rng.uniform(0, 2 * np.pi, terms))
