"""Effects told of in numbers that no sensor has: what is wrong there has another law, and all names make up for it."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from imubench.diagnosis.config.residuals import EXCESS_NOISE
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks.excess_noise import unexplained
from imubench.diagnosis.result import Finding, Where
from imubench.diagnosis.solve.levenberg_marquardt import Fit
from imubench.effects.effect import Reading
from imubench.jets import Jet


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


def unheard(fit: Fit, h: Hypothesis) -> bool:
    """Return whether a fitted hum is hardly in its accelerometer's samples: the motion would have to undo it.

    Where a measured pose counts less often than such a hum turns round, it follows a motion that hums only as an image
    of its own slower errors; a hum at the sensor that cancels that motion explains them. A motion knows of no hum: what
    the samples have in the phase of one, in a window of Hann's, is at least half of it.
    """
    imu = next((i for i in fit.model.recording.imus if h.effect.tone and i.name == h.at), None)
    if imu is None:
        return False
    model, state = fit.model, fit.state
    time = model.moment(state, imu.time, imu.name).time
    still = Jet(np.zeros((imu.time.size, 3)))
    hum = h.effect.error(Reading(still, still, time), model.values(h, state)).accel
    if hum is None:
        return False
    counts = (model.masks or {}).get(f"{imu.name}.accel", np.ones(imu.time.size, dtype=bool))
    place = (imu.time - imu.time[0]) / (imu.time[-1] - imu.time[0])
    weight = (counts * np.sin(np.pi * place) ** 2)[:, None]
    read = imu.accel - np.sum(weight * imu.accel, axis=0) / np.sum(weight)
    return bool(2 * np.sum(weight * read * hum.value) < np.sum(weight * hum.value**2))


def lawless(at: str, where: Sequence[Where]) -> Finding:
    """Return what is at such a place as a finding without a name; `where` the nominal fit's residuals were."""
    return unexplained(next((w for w in where if w.at == at), Where(at, {}, (), (), "", 1.0)))


__all__ = ["implausible_places", "lawless", "unheard"]
