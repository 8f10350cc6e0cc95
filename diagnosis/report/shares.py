"""Which share of what differs each finding explains: what comes back when it alone is taken out of the final model.

With P(y) the power of (y - measured) / noise, summed over samples and channels, and y0, y, y_f what MuJoCo plays of the
declared model, of the model with all findings, and of that without the finding f::

    share_f = (P(y_f) - P(y)) / (P(y0) - P(y)),  within 0 and 1

The numerator is taken over the channels in which f is compared, those where it matters most, so it is a lower bound.
Shares need not add up to 1: two findings that do the same each bring back little.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from imubench.diagnosis.evidence import Comparison, Evidence
from imubench.diagnosis.result import Diagnosis


def with_shares(d: Diagnosis, evidence: Evidence) -> Diagnosis:
    """Return a diagnosis whose findings have their shares, where the evidence compares them and none is given.

    Args:
        d: the diagnosis.
        evidence: `comparisons` in the order of its findings, `simulated` with every channel.
    """
    explained = sum(power_explained(c) for c in evidence.simulated)
    if explained <= 0:
        return d
    compared = (*evidence.comparisons, *[()] * len(d.findings))
    found = tuple(
        replace(f, share=share(some, explained)) if some and f.share is None else f
        for f, some in zip(d.findings, compared, strict=False)
    )
    return replace(d, findings=found)


def share(compared: Sequence[Comparison], explained: float) -> float:
    """Return the share of one finding, compared without and with it, in the power that all findings explain."""
    return float(np.clip(sum(power_explained(c) for c in compared) / explained, 0.0, 1.0))


def power_explained(c: Comparison) -> float:
    """Return by how much the power of the error over the noise falls in one channel, summed over its samples."""
    before, after = ((y - c.measured) / c.noise for y in (c.before, c.after))
    return float(before @ before - after @ after)


def explained_share(compared: Sequence[Comparison]) -> float | None:
    """Return the share of the power of what differs that the model with all findings explains, over all channels.

    Between 0 and 1; None where nothing was compared. It needs no noise that is right: a wrong one only weighs channels.
    """
    total = sum(float(np.sum(((c.before - c.measured) / c.noise) ** 2)) for c in compared)
    if total <= 0:
        return None
    return float(np.clip(sum(power_explained(c) for c in compared) / total, 0.0, 1.0))


__all__ = ["explained_share", "power_explained", "share", "with_shares"]
