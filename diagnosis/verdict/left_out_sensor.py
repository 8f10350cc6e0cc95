"""How well the other channels foretell a sensor that the fit was not shown.

A triple's rows are taken out, parameters held, and the motion follows the rest in one Gauss-Newton step from the fit:
N x = -g over the rows that stay; what it then says of the triple is r + J x, in standard deviations of its noise.
"""

from collections.abc import Mapping
from contextlib import suppress

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.residuals import Parameters, Rows
from imubench.diagnosis.residual_checks.fit_summary import CHANNELS_WITH_UNIT, Weighed
from imubench.diagnosis.result import CHANNEL_UNIT, Change
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.linearize import Linear, linearise
from imubench.diagnosis.solve.normal_equations import Normal
from imubench.diagnosis.solve.threads import one_thread


def left_out_change(before: Weighed, after: Weighed) -> Change:
    """Return the errors of channels left out, by the fit before and after, over the same noise."""
    noise = {level.group: level.used for level in after.levels}
    first, then = (left_out(w.fit, noise) for w in (before, after))
    both = [name for name in first if name in then]
    return Change({n: first[n] for n in both}, {n: then[n] for n in both}, CHANNEL_UNIT)


@one_thread
def left_out(fit: Fit, noise: Mapping[str, float]) -> dict[str, float]:
    """Return the RMS error over the noise of every IMU channel, foretold from the others; `noise` by group.

    A channel without which the motion is not known is not among them.
    """
    model, bare = fit.model, Parameters({})
    parts = [linearise(r, model.tracks, bare) for r in fit.rows]
    out: dict[str, float] = {}
    for rows, part in zip(fit.rows, parts, strict=True):
        sensor, _, kind = rows.name.partition(".")
        if not rows.counts or kind not in ("gyro", "accel"):
            continue
        normal = Normal.of(model.tracks, bare, [other for other in parts if other is not part])
        with suppress(NotPositiveDefiniteError):
            motion = normal.band.factor().solve(-normal.gradient[:, :, None])[:, :, 0]
            off = _foretold(rows, part, motion.reshape(-1, model.tracks.width), fit) / noise[rows.name]
            power = [model.averaging.power(rows.name, float(p)) for p in np.mean(off**2, axis=0)]
            names = CHANNELS_WITH_UNIT[kind][0]
            out |= {f"{sensor}.{n}": float(np.sqrt(p)) for n, p in zip(names, power, strict=True)}
    return out


def _foretold(rows: Rows, part: Linear, motion: Array, fit: Fit) -> Array:
    """Return the errors (n, 3) of a triple in units of its rows' own standard deviation at noise level 1."""
    whitened = part.residual + part.along(motion[:, :, None])[:, :, 0]
    return np.asarray(whitened * fit.noise[rows.name] * fit.loose)
