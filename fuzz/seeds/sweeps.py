"""What `imubench sweep` reads: a sweep over two numbers of a rig and of an effect."""

from pathlib import Path

from fuzz.seeds import laid_out

SWEEP = b"""
name = "seed"
seconds = 2
rate = 50
recordings = 1
figure = "maxae"
quantile = 0.9
limit_deg = 2.5

[[rig]]
family = "hinge"
segment_length = 0.3

[[effect]]
name = "gyro_bias"
bias = { std = 0.01 }

[[axis]]
parameter = "rig[0].mount_distance"
values = [50, 100]
unit = "mm"
label = "distance of the IMUs"

[[axis]]
parameter = ["effect.gyro_bias.bias.std"]
from = 0.1
to = 1
count = 2
scale = "log"
unit = "deg/s"
"""


@laid_out
def sweep(folder: Path) -> None:
    """Write a sweep."""
    (folder / "sweep.toml").write_bytes(SWEEP)
