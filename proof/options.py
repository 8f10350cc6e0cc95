"""What a case may be asked to be, its random streams, and the motion of a rig as the sensors will feel it."""

import zlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from imubench.proof.frames import Track
from imubench.proof.rigs import SHAPES, Shape
from imubench.proof.rotation import Array, Parameters


@dataclass(frozen=True)
class Effect:
    """One effect of a case: its name, where it sits, its parameters, and whether the table of effects has it."""

    effect: str
    at: str
    parameters: Parameters
    inside: bool = True


COLOUR = 0.2  # of the white noise's power: coloured noise that is no mismatch, at most
CORNERS = (0.5, 5.0)  # Hz, between which its corner is


@dataclass(frozen=True)
class Options:
    """Everything about a case beside its effects and its seed."""

    rig: str = "hinge"
    seconds: float = 60.0
    rate: float = 100.0  # Hz, of imu1
    rate2: float | None = None  # Hz, of imu2; None: as imu1
    base: str = "free"  # hinge: free | fixed
    swing: bool = False  # pendulum, or hinge on a fixed base: free swings in declared windows
    encoder: bool = False  # hinge
    pose: bool | None = None  # a measured pose of every segment; None: for the free body only
    band: float = 4.0  # Hz, the fastest the hand moves
    vigour: float = 1.0  # factor on the hand's rates and accelerations
    rest: float = 0.2  # share of the hand's phases in which it rests; 1: never moves
    gyro_noise: float = 0.002  # rad/s per sample
    accel_noise: float = 0.02  # m/s^2 per sample
    noise: float = 1.0  # factor on every sensor's noise; 0: none at all
    colour: float = 0.0  # power of coloured noise over that of the white, up to COLOUR
    corner: float | None = None  # Hz, of coloured noise; None: drawn within CORNERS
    misdeclared: float = 0.0  # declared noise std = true * (1 + this), up to 0.15
    declare_noise: bool = True
    position_std: float = 0.004  # m, geometry errors are drawn with these
    rotation_std: float = 0.02  # rad
    geometry_error: bool = True  # False: the declared mounts are true
    declare_geometry: bool = True  # False: the two stds are not said
    gaps: int = 0  # per IMU, 0.05 to 0.3 s without samples
    repeats: int = 0  # per IMU, samples that say the last one again
    gravity: float = 9.81  # m/s^2, declared
    reference: bool = True
    name: str = "recording"

    @property
    def shape(self) -> Shape:
        """What the rig is made of."""
        return SHAPES[self.rig]

    @property
    def clamped(self) -> bool:
        """Whether segment 1 is bolted to the world."""
        return self.shape.hinge and self.base == "fixed"


@dataclass
class World:
    """The motion of a rig on the fine grid."""

    t: Array  # (n,) s
    segments: list[Track]
    angle: tuple[Array, Array, Array]  # hinge angle, or the pendulum's swing, and its derivatives
    swings: list[tuple[float, float]] = field(default_factory=list)  # s, windows without a hand
    declared: dict[str, Any] = field(default_factory=dict)  # keys of recording.toml that the rig sets
    hangs: float = 0.0  # rad, the angle at which it hangs at rest


def stream(seed: int, purpose: str) -> np.random.Generator:
    """Return the random stream of one purpose: the same motion, say, whatever else is drawn."""
    return np.random.default_rng([seed, zlib.crc32(purpose.encode())])


def find(effects: list[Effect], name: str, at: str | None = None) -> Parameters | None:
    """Return the parameters of an effect among those of a case, None when it is not there."""
    return next((e.parameters for e in effects if e.effect == name and at in (None, e.at)), None)
