"""Where samples that are no measurement are off a simulation: what clips, is repeated or is knocked acts there alone.

No fit has these samples in it, so what is found in them shows neither in residuals nor in what findings add to a
simulation. They are off by what the sensor lost.
"""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from imubench.diagnosis.evidence import Comparison, Trace
from imubench.diagnosis.residual_checks.fit_summary import CHANNELS_WITH_UNIT


def lost(
    channels: Sequence[Comparison], masks: Mapping[str, NDArray[np.bool_]], sensors: Collection[str]
) -> tuple[Trace, ...]:
    """Return measured minus simulated at the samples that do not count, zero elsewhere, by triple of some sensors.

    Args:
        channels: beside the model with all findings.
        masks: samples (n,) that count, by triple.
        sensors: in whose samples something was found.
    """
    out = []
    for group, counts in masks.items():
        at, part = group.split(".")
        names = CHANNELS_WITH_UNIT[part][0]
        own = [c for c in channels for name in names if c.channel == f"{at}.{name}" and c.time.size == counts.size]
        if at in sensors and len(own) == len(names) and not counts.all():
            values = np.stack([np.where(counts, 0.0, c.measured - c.after) for c in own], axis=1)
            out.append(Trace(at, part, names, own[0].unit, own[0].time, values, own[0].noise))
    return tuple(out)


__all__ = ["lost"]
