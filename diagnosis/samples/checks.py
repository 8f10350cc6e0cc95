"""The checks of raw samples that come before any fit: what single samples, still moments and spectra already tell.

From here on a fit knows which samples to leave out. Each check is built to be silent on a clean recording,
whatever its motion below 10 Hz.

Found in 40 s at 50, 100 and 200 Hz with noise of 0.002 rad/s and 0.02 m/s^2, 16 recordings each, motion to 1 to 10 Hz:
saturation at 95 % of the largest reading (16 of 16); quantisation from a step of 2 noise std (16; at 1.5 none, it adds
under a fifth of power); dropouts from 1 % of the samples (16; of 0.5 % 7), held or missing; a hum of 0.02 m/s^2 above
13 Hz (16; of 0.01 13), or down to 6 Hz above twice the motion's end; knocks of 6 m/s^2 and 30 ms (16; of 3 10); noise
of 1.35 times the declared (15; at 1.25 none, a declared level may be off by that).

Not told apart here: a stop or play in the joint knocks as well, and so does a limb let go outside a declared swing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from imubench.diagnosis.config.samples import SCREENING
from imubench.diagnosis.samples import check_findings as said
from imubench.diagnosis.samples import sample_faults
from imubench.diagnosis.samples.check_findings import RawFinding
from imubench.diagnosis.samples.even_grid import stretches
from imubench.diagnosis.samples.impacts import knocks
from imubench.diagnosis.samples.noise_floor import Level, rests, white_level
from imubench.diagnosis.samples.rest_noise import rest_noise
from imubench.diagnosis.samples.sample_faults import UNIT_OF_PART, Mask
from imubench.diagnosis.samples.tones import line
from imubench.diagnosis.windows import Windows
from imubench.recording import Encoder, Imu


@dataclass(frozen=True)
class RawChecks:
    """What the raw samples of one sensor say."""

    findings: tuple[RawFinding, ...]
    masks: Mapping[str, Mask]  # "imu1.gyro" -> (n,) samples that a fit must leave out
    struck: Mapping[str, Mask]  # the part of `masks` that is knocks: a stop or play in the joint knocks as well
    still: Windows  # s, at rest
    noise: Mapping[str, float]  # "imu1.gyro" -> std per sample: at rest, else of white noise above 12 Hz
    colour: Mapping[str, float]  # the same keys, correlation of neighbouring samples at rest; empty without a rest
    white: Mapping[str, float] = field(default_factory=dict)  # the same keys, where what is above 12 Hz is noise alone
    rest: Mapping[str, float] = field(default_factory=dict)  # the same keys, where the sensor has rested for sure


def check(imu: Imu, free_swings: Windows = ()) -> RawChecks:
    """Return what the raw samples of an IMU say; nothing where there are fewer than 32.

    The jerk with which a limb is let go, just before one of `free_swings` (s) begins, is no knock, unless it is far
    louder than such a jerk.
    """
    n = imu.time.size
    none = np.zeros(n, dtype=bool)
    if n < SCREENING.least_samples:
        nothing = {f"{imu.name}.{part}": none for part in UNIT_OF_PART}
        return RawChecks((), nothing, nothing, (), {}, {})
    readings = {"gyro": imu.gyro, "accel": imu.accel}
    step = {part: sample_faults.steps(x) for part, x in readings.items()}
    lost = sample_faults.lost(imu.time, np.hstack([imu.gyro, imu.accel]), np.hstack([*step.values()]))
    rate = 1 / float(np.median(np.diff(imu.time)))
    pieces = stretches(imu.time, imu.gyro, imu.accel, lost.held)

    first = {part: white_level(pieces, part, rate, none) for part in UNIT_OF_PART}
    _, resting = rests(pieces, rate, stds(first), n)
    clip, limits = {}, {}
    for part, x in readings.items():
        known = [s for s in (said.declared(imu, part), first[part] and first[part].std) if s]  # type: ignore[union-attr]
        clip[part], limits[part] = sample_faults.clipped(
            imu.time, x, step[part], min(known, default=0.0), lost.held, resting
        )
    let_go = np.zeros(n, dtype=bool)
    for start, _ in free_swings:
        let_go |= (imu.time > start - SCREENING.release_s) & (imu.time < start + SCREENING.release_s / 4)
    knocked = knocks(
        pieces, rate, spread(clip["accel"], SCREENING.clip_ring_samples), float(step["accel"].max()), let_go
    )
    struck = knocked.samples | knocked.wild if knocked else none
    skip = {
        "gyro": spread(clip["gyro"], SCREENING.beside_clip_samples) | struck,
        "accel": spread(clip["accel"], SCREENING.beside_clip_samples) | struck,
    }
    levels = {part: white_level(pieces, part, rate, skip[part]) for part in UNIT_OF_PART}
    rest, _ = rests(pieces, rate, stds(levels), n)

    findings: list[RawFinding | None] = []
    for part in UNIT_OF_PART:
        if limits[part].size:
            findings.append(said.saturation_finding(imu, part, clip[part], limits[part]))
        coarse = said.quantisation_finding(imu, part, step[part], said.noise_now(rest, levels[part], part))
        width = float(coarse.parameters["step"][0]) if coarse else 0.0
        findings += [coarse, said.noise_finding(imu, part, levels[part], rest.std.get(part), width)]
    findings += said.dropouts_finding(imu, lost)
    if knocked and knocked.times.size:
        findings.append(said.impacts_finding(imu, knocked))
    hum = line(pieces, rate, skip["accel"], stds(levels))
    if hum and np.abs(hum.amplitude).max() > step["accel"].max() / np.pi:  # the largest line of a rounded slow motion
        findings.append(said.hum_finding(imu, hum, rate))
    noise = {part: said.noise_now(rest, levels[part], part) for part in UNIT_OF_PART}
    return RawChecks(
        tuple(f for f in findings if f),
        {f"{imu.name}.{part}": skip[part] | lost.held for part in UNIT_OF_PART},
        {f"{imu.name}.{part}": struck for part in UNIT_OF_PART},
        rest.windows,
        {f"{imu.name}.{part}": std for part, std in noise.items() if std is not None},
        {f"{imu.name}.{part}": r for part, r in rest.colour.items()},
        {
            f"{imu.name}.{part}": level.std
            for part, level in levels.items()
            if level is not None and level.white and level.std > 0
        },
        {f"{imu.name}.{part}": std for part, std in rest_noise(imu, rest.windows, step).items()},
    )


def check_encoder(encoder: Encoder) -> RawChecks:
    """Return an encoder's mask and its step as noise, step / sqrt(12); the table of effects has none at an encoder.

    An encoder repeats itself honestly at rest and between its steps, so repeats are left in.
    """
    angle = encoder.angle
    step = sample_faults.lattice(angle)
    noise = {"encoder.angle": step / np.sqrt(12)} if step else {}
    none = {"encoder.angle": np.zeros(angle.size, dtype=bool)}
    return RawChecks((), none, none, (), noise, {})


def stds(levels: Mapping[str, Level | None]) -> dict[str, float]:
    """Return the levels that are known."""
    return {part: level.std for part, level in levels.items() if level is not None}


def spread(mask: Mask, by: int) -> Mask:
    """Return a mask (n,) with `by` samples more on either side of each run."""
    if not mask.any():
        return mask
    return np.asarray(np.convolve(mask, np.ones(2 * by + 1), mode="same") > 0.5)
