"""Scenarios of the spherical pendulum (Garcia de Villa et al., section IV-A)."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from imubench.errors import unknown
from imubench.scenarios.scenario import Experiment, Play, Scenario, prescribed
from imubench.sim.injected import Injected
from imubench.sim.motion import AngleMotion
from imubench.sim.rigs import Rig, pendulum, springs
from imubench.sim.signals import Sines

DURATION = 10.0  # s
R_TEXT = np.array([-0.06, 0.02, 0.2])  # m, IV-A: along the limb, the default
R_CAPTIONS = np.array([0.2, 0.02, -0.06])  # m, as figures 4 and 5 have it: across the limb
R_AMPLITUDE = np.array([0.02, 0.005, 0.02])  # m, at 1 Hz

SoftTissue = Literal["none", "paper", "sliding", "sprung"]
SOFT_TISSUES = ("none", "paper", "sliding", "sprung")


def ellipse() -> AngleMotion:
    """Return the paper's motion: 17, 9 and 3 deg about x, y and z, periods 1, 1 and 1.5 s, on an ellipse."""
    x, y, z = np.deg2rad([17.0, 9.0, 3.0])
    return AngleMotion(
        tilt=Sines(x, 1.0),
        spin=Sines(y, 1.0, np.pi / 2),  # a quarter period behind: the limb goes round
        heading=Sines(z, 1 / 1.5),
    )


def limb(
    soft_tissue: SoftTissue = "none",
    r: ArrayLike = R_TEXT,
    amplitude: ArrayLike = R_AMPLITUDE,
    frequency: float = 1.0,
    phase: float = 0.0,
) -> Rig:
    """Return the paper's pendulum with one of four kinds of soft tissue under its sensor.

    `r` (3,) m points from the sensor to the pivot; `paper` and `sliding` add amplitude (3,) m times
    sin(2 pi frequency t + phase) to it. `sprung` hangs the sensor on springs that are as soft, 6 Hz along
    and 9 Hz about, damped by a fifth; the numbers of the slide mean nothing to it.
    """
    if soft_tissue not in SOFT_TISSUES:
        raise unknown("soft tissue", soft_tissue, SOFT_TISSUES)
    rig = pendulum()
    mount = replace(rig.mounts[0], position=-np.asarray(r, dtype=float))
    if soft_tissue == "sprung":
        mount = replace(mount, translation=springs(6.0, 0.2), rotation=springs(9.0, 0.2))
    elif soft_tissue != "none":
        a = np.broadcast_to(np.asarray(amplitude, dtype=float), (3,))
        path = (Sines(-a[0], frequency, phase), Sines(-a[1], frequency, phase), Sines(-a[2], frequency, phase))
        mount = replace(mount, path=path, path_felt=soft_tissue == "sliding")
    return replace(rig, mounts=(mount,))


def circling(soft_tissue: SoftTissue) -> Play:
    """Return the paper's experiment with one kind of soft tissue."""

    def played(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
        return prescribed(limb(soft_tissue), ellipse(), seconds, rng, effects)

    return played


PLAYED: tuple[tuple[SoftTissue, str, str], ...] = (
    ("none", "pendulum-rigid", "a limb circles about its pivot, IMU fixed"),
    ("paper", "pendulum-paper", "its IMU slides by 2 cm, which the accelerometer does not feel"),
    ("sliding", "pendulum-sliding", "its IMU slides by 2 cm, and the accelerometer feels it"),
    ("sprung", "pendulum-sprung", "its IMU hangs on springs and dampers, along and about"),
)

SCENARIOS = tuple(
    Scenario(name, summary, "arve-d", "xsens_mtw_awinda", circling(kind), "pendulum", DURATION)
    for kind, name, summary in PLAYED
)
