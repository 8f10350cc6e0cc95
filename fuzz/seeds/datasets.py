"""What `imubench generate` reads and writes: specs with the files they name, a finished dataset, one half done."""

import json
from pathlib import Path

import numpy as np

from fuzz.seeds import laid_out
from imubench.dataset.generate import JOB, generate
from imubench.dataset.identity import identity
from imubench.dataset.motion_file import COLUMNS
from imubench.dataset.shard import Job, make_shard
from imubench.dataset.spec import load_spec
from imubench.format1.tables import write_table

SPEC = b"""
format = 1
name = "seed"
summary = "every kind of table"
licence = "CC-BY-4.0"
seconds = [2, 3]
rate = 50
recordings_per_rig = 2
recordings_per_file = 2
precision = "double"
truth = "full"
declared = { position_std = 0.005, rotation_std = 0.02 }
splits = { train = 0.5, test = 0.5 }

[[rig]]
family = "hinge"
weight = 2
mount_distance = [0.05, 0.2]
mount_offset = [-0.03, 0.03]
mount_rotation = [-0.1, 0.1]
segment_mass = { low = 0.2, high = 2, scale = "log" }
gravity = 9.81

[[rig]]
family = "pendulum"
soft_probability = 0.5
soft = { frequency = [6, 20], damping_ratio = 0.1 }

[[motion]]
kind = "random"
bandwidth = [0.5, 2]
turn = [0.3, 1.0]

[[motion]]
kind = "pendulum"
amplitude = [0.6, 1.6]

[[motion]]
kind = "file"
path = "moves.csv"
weight = 0.5

[encoder]
probability = 0.5
noise_std = 0.0005

[[pose]]
segment = "segment1"
position_noise_std = 0.001

[[imu]]
profile = "own"
file = "profiles.toml"

[[effect]]
name = "gyro_bias"
probability = 0.5
bias = { std = 0.02 }

[[effect]]
name = "dropouts"
at = "imu2"
probability = 0.2
fraction = [0.01, 0.1]
mode = "missing"
"""
PROFILES = b"""
[own]
summary = "a part of one's own"
rate = { value = 100, unit = "Hz", source = "datasheet, table 3" }
jitter_std = { value = 0.1, unit = "ms", source = "measured" }
clock_skew = { value = 20, unit = "ppm", source = "datasheet" }
dropout_fraction = { value = 0.01, unit = "1", source = "measured" }
dropout_mode = "held"
[own.gyro]
noise_density = { value = 0.01, unit = "deg/s/sqrt(Hz)", source = "datasheet", note = "typical" }
bias_std = { value = 0.5, unit = "deg/s", source = "datasheet" }
bias = { value = [0.1, 0.0, -0.1], unit = "deg/s", source = "measured" }
scale_std = { value = 1, unit = "%", source = "datasheet" }
misalignment = { value = [0.01, 0, 0, 0, 0, 0.01], unit = "1", source = "measured" }
range = { value = 2000, unit = "deg/s", source = "datasheet" }
step = { value = 0.06, unit = "deg/s", source = "datasheet" }
bandwidth = { value = 40, unit = "Hz", source = "datasheet" }
[own.accel]
noise_std = { value = 2, unit = "mg", source = "datasheet" }
bias_instability = { value = 40, unit = "ug", source = "datasheet" }
bias_correlation_time = { value = 100, unit = "s", source = "datasheet" }
range = { value = 16, unit = "g", source = "datasheet" }
"""
SMALL = b"""
name = "small"
seconds = 2
rate = 50
recordings_per_rig = 1
recordings_per_file = 2
[[rig]]
family = "hinge"
[encoder]
[[pose]]
[[effect]]
name = "gyro_bias"
"""
COUNT = 2


def _spec(folder: Path, suffix: str) -> None:
    (folder / "spec.toml").write_bytes(SPEC.replace(b"moves.csv", f"moves.{suffix}".encode()))
    (folder / "profiles.toml").write_bytes(PROFILES)
    time = np.arange(0.0, 5.0, 0.05)
    moves = {name: 0.2 * np.sin((1 + 0.2 * k) * time + k) for k, name in enumerate(COLUMNS)}
    write_table(folder / f"moves.{suffix}", {"time": time, **moves})


@laid_out
def spec(folder: Path) -> None:
    """Write a spec with every kind of table in it, and the files that it names."""
    _spec(folder, "csv")


@laid_out
def spec_parquet(folder: Path) -> None:
    """Write the spec with its motion in a Parquet file."""
    _spec(folder, "parquet")


def job(folder: Path) -> Job:
    """Return the job of the small spec in a folder; the dataset is `data` beside it."""
    return Job(load_spec(folder / "spec.toml").content, 0, COUNT, str(folder / "data"))


@laid_out
def finished(folder: Path) -> None:
    """Write a dataset and its spec."""
    (folder / "spec.toml").write_bytes(SMALL)
    generate(job(folder), workers=0)


@laid_out
def half_done(folder: Path) -> None:
    """Write what a run leaves that was killed after its first file."""
    (folder / "spec.toml").write_bytes(SMALL)
    asked = job(folder)
    make_shard(asked, 0)
    (folder / "data" / JOB).write_text(json.dumps(identity(asked)), encoding="utf-8")


@laid_out
def in_use(folder: Path) -> None:
    """Write the lock file of a run that goes on, with its process in it."""
    (folder / "lock").write_text("12345\n", encoding="utf-8")
