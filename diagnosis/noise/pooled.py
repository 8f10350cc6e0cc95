"""Two IMUs on one motion, of which the fit believes the one and blames the other for all that it cannot explain."""

import numpy as np

from imubench.diagnosis.config.shared import DECLARED_NOISE
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import CHANNELS
from imubench.diagnosis.solve.levenberg_marquardt import solve


def with_pooled_noise(fit: Fit) -> Fit:
    """Return the fit with what it leaves shared by both IMUs, where it holds one alone for noisy; else the fit itself.

    What two IMUs read of one motion says how loud both are together. Estimated one by one, the one that is believed a
    little more is believed in the end: its level falls, the other's rises, and effects are found at the wrong one.
    """
    told = declared(fit.model)
    noise = dict(fit.noise)
    for part in CHANNELS:
        names = [n for n in (f"{i.name}.{part}" for i in fit.model.recording.imus) if n in told and n in noise]
        times = np.array([noise[n] / told[n] for n in names])
        power = [fit.model.averaging.power(n, t**2) for n, t in zip(names, times, strict=True)]
        if len(names) == 2 and max(power) > DECLARED_NOISE.most_power and times.min() < 1 + DECLARED_NOISE.std_error:
            shared = float(np.sqrt(np.mean(times**2)))
            noise |= {n: shared * told[n] for n in names}
    return fit if noise == fit.noise else solve(fit.model, fit.state, noise, fit.anchor, steps=SOLVER.few_steps)


__all__ = ["with_pooled_noise"]
