"""An effect added to a recording that exists: what its sensors would have read, had they had it.

Only what an IMU does to its own reading can be added to samples: the parallel errors, drift, filter, clock, hum,
knocks, clipping, rounding, lost samples, noise. Between samples a cubic spline stands in for the world.
"""

import shutil
import tomllib
from dataclasses import replace
from pathlib import Path, PureWindowsPath
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from imubench.proof.frames import STEP
from imubench.proof.options import Effect, Options, stream
from imubench.proof.ranges import drawn, twins
from imubench.proof.rotation import Array
from imubench.proof.sensors import (
    CHANNELS,
    Samples,
    digitised,
    humming,
    knocking,
    lost,
    low_passed,
    parallel_errors,
    world_time,
)
from imubench.proof.told import told
from imubench.proof.write import write_table

ADDABLE = (
    "gyro_bias", "accel_bias", "gyro_drift", "accel_drift", "gyro_scale", "accel_scale", "gyro_misalignment",
    "accel_misalignment", "g_sensitivity", "gyro_noise", "accel_noise", "low_pass", "time_offset", "clock_skew",
    "saturation", "quantisation", "dropouts", "vibration", "impacts",
)  # fmt: skip
NOISES = ("gyro_noise", "accel_noise")
TWO_CLOCKS = ("time_offset", "clock_skew")  # need another clock in the recording
STILL = 0.1  # share of half-second windows, the quietest, from which an undeclared noise level is taken


def addable(recording: Path) -> list[tuple[str, str]]:
    """Return every (effect, place) that can be added to a recording in format 1.

    A louder noise is one only beside a level that is declared.
    """
    header = read_header(recording)
    clocks = len(header["imu"]) + len(header.get("encoder", [])) + len(header.get("pose", []))
    names = [name for name in ADDABLE if clocks > 1 or name not in TWO_CLOCKS]
    told = [(name, imu) for imu in header["imu"] for name in names]
    return [(name, imu["name"]) for name, imu in told if name not in NOISES or f"{name}_std" in imu]


def add(recording: Path, out: Path, name: str, at: str, seed: int, strength: str) -> dict[str, Any]:
    """Copy a recording in format 1 (CSV) to the new folder `out` with an effect in it, and return the truth."""
    header = read_header(recording)
    entry = next(imu for imu in header["imu"] if imu["name"] == at)
    samples = read_samples(recording / entry["file"])
    options = options_of(header, entry, samples)
    effect = Effect(name, at, drawn(name, at, options, seed, strength))
    if "share_of_peak" in effect.parameters:
        p = effect.parameters
        peak = max(float(np.abs(getattr(samples, channel)).max()) for channel in p["channels"])
        effect = replace(effect, parameters={"limit": p["share_of_peak"] * peak, "channels": p["channels"]})
    copy(recording, out)
    write_samples(out / entry["file"], with_effect(samples, effect, options, seed))
    return {
        "format": 1,
        "seed": seed,
        "rig": header["rig"],
        "effects": [told(effect)],
        "equivalent": [told(e) for e in twins([effect], options)],
    }


def copy(recording: Path, out: Path) -> None:
    """Copy a recording to the new folder `out`, every IMU's table written as `add` would: digits must tell nothing."""
    header = read_header(recording)
    for name in ("recording.toml", *files_of(header)):
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(recording / name, out / name)
    for imu in header["imu"]:
        write_samples(out / imu["file"], read_samples(recording / imu["file"]))


def write_samples(file: Path, samples: Samples) -> None:
    """Write an IMU's table."""
    columns = {"time": samples.time}
    for prefix, values in (("gyr", samples.gyro), ("acc", samples.accel)):
        columns |= {f"{prefix}_{axis}": values[:, k] for k, axis in enumerate("xyz")}
    write_table(file, columns)


def with_effect(samples: Samples, effect: Effect, options: Options, seed: int) -> Samples:
    """Return an IMU's samples as they would be with the effect."""
    at, effects, time, p = effect.at, [effect], samples.time, effect.parameters
    there = world_time(time, at, effects)
    true = {channel: getattr(samples, channel) for channel in CHANNELS}
    out = {}
    for channel in CHANNELS:
        x = true[channel] + parallel_errors(channel, at, effects, true)
        if effect.effect == "low_pass" and channel in p["channels"]:
            x = filtered(time, x, float(p["cutoff"]))
        if effect.effect in TWO_CLOCKS:
            x = CubicSpline(time, x)(np.clip(there, time[0], time[-1]))
        if effect.effect == f"{channel}_drift":
            x = x + np.outer(time - time[0], np.asarray(p["rate"], dtype=float))
        if effect.effect == "vibration" and channel == "accel":
            x = x + humming(there, p, 0.0, stream(seed, f"hum {at}"))
        if effect.effect == "impacts":
            x = x + knocking(time, p, channel, stream(seed, f"knocks {at}"))
        if effect.effect == f"{channel}_noise":
            usual = options.gyro_noise if channel == "gyro" else options.accel_noise
            more = np.sqrt(max(float(p["std"]) ** 2 - usual**2, 0.0))
            x = x + more * stream(seed, f"noise {at} {channel}").standard_normal(x.shape)
        out[channel] = digitised(x, channel, at, effects)
    after = Samples(time, out["gyro"], out["accel"])
    return lost(after, at, effects, replace(options, gaps=0, repeats=0), stream(seed, f"lost {at}"))


def filtered(time: Array, x: Array, cutoff: float) -> Array:
    """Return samples (m, 3) behind a first-order low-pass, run on the generator's fine grid."""
    fine = np.arange(time[0], time[-1] + STEP, STEP)
    y = low_passed(CubicSpline(time, x)(fine), cutoff)
    return np.asarray(CubicSpline(fine, y)(time))


def read_header(recording: Path) -> dict[str, Any]:
    """Return recording.toml; ValueError where it names a file that is not below its folder."""
    header = tomllib.loads((recording / "recording.toml").read_text(encoding="utf-8"))
    files_of(header)
    return header


def files_of(header: dict[str, Any]) -> list[str]:
    """Return the files that a recording.toml names; ValueError for one that is not below its folder."""
    entries = [entry for kind in ("imu", "encoder", "pose") for entry in header.get(kind, [])]
    names = [str(entry["file"]) for entry in (*entries, *filter(None, [header.get("reference")]))]
    for name in names:
        path = PureWindowsPath(name)  # reads both separators and drive letters
        if not path.parts or path.root or path.drive or ".." in path.parts:
            raise ValueError(f"expected a file below the recording's folder, got '{name}'")
    return names


def read_samples(file: Path) -> Samples:
    """Return an IMU's table, CSV with the columns of format 1 in any order."""
    table = np.genfromtxt(file, delimiter=",", names=True)
    gyro, accel = (np.stack([table[f"{k}_{axis}"] for axis in "xyz"], axis=1) for k in ("gyr", "acc"))
    return Samples(np.asarray(table["time"]), gyro, accel)


def options_of(header: dict[str, Any], entry: dict[str, Any], samples: Samples) -> Options:
    """Return the options that a recording would have been made with, as far as the size of an effect needs them."""
    base = header.get("base", "free")
    return Options(
        rig=header["rig"],
        base=base,
        seconds=float(samples.time[-1]),
        rate=float(entry["rate"]),
        gyro_noise=float(entry.get("gyro_noise_std") or quiet_std(samples, samples.gyro)),
        accel_noise=float(entry.get("accel_noise_std") or quiet_std(samples, samples.accel)),
    )


def quiet_std(samples: Samples, x: Array) -> float:
    """Return the noise std of the quietest half-second windows, from second differences."""
    d = np.diff(x, 2, axis=0) / np.sqrt(6.0)
    width = max(int(0.5 / np.median(np.diff(samples.time))), 4)
    blocks = d[: len(d) // width * width].reshape(-1, width * x.shape[1])
    return float(np.quantile(np.sqrt((blocks**2).mean(axis=1)), STILL))
