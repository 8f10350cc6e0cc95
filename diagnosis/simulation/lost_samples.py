"""Where what is found in the samples themselves acts: it shows neither in residuals nor in what findings add.

No fit has samples in it that clip, are repeated or are knocked. They are off a simulation by what the sensor lost. Nor
has it a hum of the raw samples, which is taken out of them first: that is as large as it was found to be.
"""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from imubench.diagnosis.evidence import Comparison, Trace
from imubench.diagnosis.residual_checks.fit_summary import CHANNELS_WITH_UNIT
from imubench.diagnosis.result import Finding
from imubench.effects import traits_of


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


def tones(channels: Sequence[Comparison], findings: Sequence[Finding]) -> tuple[Trace, ...]:
    """Return the steady lines (n, 3) that findings add to the readings of a triple, at some phase.

    Args:
        channels: beside the model with all findings.
        findings: those that are not in the fit.
    """
    out = []
    for f in findings:
        tone, part = traits_of(f.effect).tone, traits_of(f.effect).channel
        names = CHANNELS_WITH_UNIT[part][0] if tone else ()
        own = [c for name in names for c in channels if c.channel == f"{f.at}.{name}"]
        if own and len(own) == len(names):
            time = own[0].time
            wave = np.cos(2 * np.pi * float(f.parameters[tone].value) * (time - time[0]))
            values = wave[:, None] * np.abs(f.parameters["amplitude"].value)
            out.append(Trace(f.at, part, names, own[0].unit, time, values, own[0].noise))
    return tuple(out)


__all__ = ["lost", "tones"]
