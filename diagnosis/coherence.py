"""Does what is left go with the motion at all? A cheap look before effects with a life of their own are tried.

White noise knows nothing of the motion. A sensor on springs, a filter, a loose joint leave residuals that
follow from it by some linear law; so each residual channel is regressed on the motion's signals around
the same moment, and what that gains is compared with what chance would gain.
"""

import numpy as np
from scipy.stats import chi2

from imubench.arrays import Array
from imubench.diagnosis.fit import Fit

LAGS = (-6, -3, -1, 0, 1, 3, 6)  # samples
CHANCE = 1e-6  # that white noise alone looks so, for one channel


def follows_motion(fit: Fit) -> dict[str, float]:
    """Return, per group of measurements, twice the largest gain of its channels over the value that chance exceeds.

    Above 1 the residuals go with the motion.
    """
    model, state = fit.model, fit.state
    out = {}
    for rows in fit.measured:
        sensor = rows.name.split(".")[0]
        imu = next((i for i in model.recording.imus if i.name == sensor), None)
        if imu is None:
            continue
        moment = model.moment(state, rows.time + model.start, sensor)
        segment = model.segments(state, moment)["segment2" if sensor == "imu2" else "segment1"]
        motion = segment.child(model.mount(imu, state, moment, segment))
        n = len(rows.time)
        signals = [np.broadcast_to(s.value, (n, 3)) for s in (motion.rate, motion.accel, motion.force)]
        out[rows.name] = _gain(rows.whitened, np.concatenate(signals, axis=1))
    return out


def _gain(residual: Array, signals: Array) -> float:
    """Return the largest gain of a channel (n, k) from signals (n, m) and their lags, over its critical value."""
    edge = max(LAGS)
    lagged = [np.roll(signals, -lag, axis=0)[edge:-edge] for lag in LAGS]
    x = np.concatenate([*lagged, np.ones((len(signals) - 2 * edge, 1))], axis=1)
    x = x / np.maximum(np.linalg.norm(x, axis=0), 1e-12)
    u, s, _ = np.linalg.svd(x, full_matrices=False)
    u = u[:, s > 1e-6 * s[0]]
    y = residual[edge:-edge]
    y = y / np.sqrt(np.mean(y**2, axis=0))
    return float(np.max(np.sum((u.T @ y) ** 2, axis=0)) / chi2.isf(CHANCE, u.shape[1]))


__all__ = ["follows_motion"]
