"""Effects told of in numbers that no sensor has: what is wrong there has another law, and all names make up for it."""

from collections import Counter

import numpy as np

from imubench.diagnosis.config.residuals import EXCESS_NOISE
from imubench.diagnosis.problem.fit import Fit


def implausible_places(fit: Fit) -> set[str]:
    """Return the IMUs that an effect is told of in numbers that no sensor has.

    Axes that read far too little, or much of each other, are what a fit makes of another effect at the same IMU, or of
    a mount whose lever arm is wrong. A mount may be turned by any angle. Nearly a third of the other axis, with nothing
    else wrong, can be a true misalignment.
    """
    sensors = [h for h in fit.model.judged if h.effect.place == "imu" and not h.effect.misplaces]
    beside = Counter(h.at for h in sensors)
    out = set()
    for h in sensors:
        most = EXCESS_NOISE.strained_alone if beside[h.at] == 1 and not h.effect.states else EXCESS_NOISE.strained
        for p in (p for p in h.effect.parameters if not p.log):
            if np.any(np.abs(fit.state.values[h.key(p.name)] - p.centre) > most * p.std):
                out.add(h.at)
    return out


__all__ = ["implausible_places"]
