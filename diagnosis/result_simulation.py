"""How far MuJoCo's simulations are from a recording, as it stands in diagnosis.json."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from imubench.diagnosis.result_checks import Pair, place, span, within
from imubench.errors import unknown

How = Literal["rolled out", "prescribed"]
HOW: tuple[str, ...] = get_args(How)


@dataclass(frozen=True)
class SimulatedChannel:
    """How far MuJoCo's simulations are from one measured channel: the RMS of simulated minus measured."""

    unit: str  # "rad/s", "m/s^2", "rad", "m"
    before: float  # of the declared model
    after: float  # of the model with all findings
    noise: float  # std of a sample, where there is only noise
    fit: float | None = None  # of the motion fit itself with the numbers of `after`, same samples; None: not told

    def __post_init__(self) -> None:
        for key in ("before", "after", "noise", "fit"):
            if (value := getattr(self, key)) is not None:
                within(value, 0.0, np.inf, f"simulation.{key}")


@dataclass(frozen=True)
class Simulation:
    """MuJoCo's simulations beside the recording."""

    how: How  # "rolled out" by forces alone in `windows_s`, or with the motion of the hand "prescribed"
    windows_s: tuple[Pair, ...]  # that are judged, on the recording's clock
    heldout: bool  # whether every number of the models was learned on other samples than it is judged on
    channels: Mapping[str, SimulatedChannel]  # "imu2.gyr_y", "encoder.hinge", "pose1.x"

    def __post_init__(self) -> None:
        if self.how not in HOW:
            raise unknown("simulation.how", self.how, HOW)
        object.__setattr__(self, "windows_s", tuple(span(p, "simulation.windows_s") for p in self.windows_s))
        for name in self.channels:
            place(name.partition(".")[0], f"simulation.channels.{name}")
