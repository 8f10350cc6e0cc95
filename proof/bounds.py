"""How visible an effect is at best: in noise standard deviations, once motion and geometry have explained their part.

Let d be the change of all readings by the effect, over the noise, A and G those by motion and mounts (`sight`). Then

    visibility = min over (x, g) of |d - A x - G g|^2 + |g / std|^2,  square root

is, for an effect of one unknown size, that size over its Cramer-Rao bound: no method can do better than a test of
that many standard deviations. `bounds` gives the Cramer-Rao bound of every parameter the same way. Faults that have no
mean (noise, dropouts, quantisation) have no such number here.
"""

from dataclasses import replace

import numpy as np

from imubench.proof.options import Effect
from imubench.proof.played import Case
from imubench.proof.rotation import Parameters
from imubench.proof.sight import Sight, sight

NO_MEAN = ("gyro_noise", "accel_noise", "dropouts", "quantisation", "thermal_walk")
NOT_ESTIMATED = ("channels", "channel", "mode", "kind", "peak", "times", "band", "time", "from", "to", "gyration")


def visibility(case: Case, seen: Sight | None = None) -> float | None:
    """Return how many standard deviations the effects of a case are away from none; None where that has no meaning.

    A `mount_pose` is measured against what the recording declares. `seen`: `sight(case)`, where that is there already.
    """
    seen = seen or sight(case)
    if seen is None or not case.effects or any(e.effect in NO_MEAN for e in case.effects):
        return None
    if any(e.effect == "mount_pose" for e in case.effects):
        return _against_declared(seen, case.effects) if len(case.effects) == 1 else None
    change = seen.readings(case.effects) - seen.readings([])
    return float(np.sqrt(max(0.0, seen.information(change[:, None])[0, 0])))


def _against_declared(seen: Sight, effects: list[Effect]) -> float:
    p = effects[0].parameters
    deviation = np.concatenate([p.get("translation", np.zeros(3)), p.get("rotation", np.zeros(3))])
    return float(np.sqrt((seen.prior[:6] * deviation**2).sum()))


def bounds(case: Case, which: int = 0) -> Parameters | None:
    """Return the Cramer-Rao bound of each parameter of one effect, in its shape; inf where it cannot be seen."""
    effect = case.effects[which]
    seen = sight(case)
    if seen is None or effect.effect in NO_MEAN:
        return None
    keys = [key for key in effect.parameters if key not in NOT_ESTIMATED]
    others = [e for i, e in enumerate(case.effects) if i != which and e.effect != "dropouts"]  # the rows stay the same
    columns, shapes = [], []
    for key in keys:
        value = np.asarray(effect.parameters[key], dtype=float)
        shapes.append(value.shape)
        for k in range(value.size):
            step = np.zeros(value.size)
            step[k] = 1e-3 * max(float(np.abs(value).max()), 1e-3)
            sides = []
            for sign in (1, -1):
                moved = replace(effect, parameters=effect.parameters | {key: value + sign * step.reshape(value.shape)})
                sides.append(seen.readings([*others, moved]))
            columns.append((sides[0] - sides[1]) / (2 * step[k]))
    mounts = slice(None)
    if effect.effect == "mount_pose":  # the geometry of the other IMU only: this one's is what is asked
        mounts = slice(6 * (len(case.mounts) - 1)) if effect.at == "imu2" else slice(6, None)
    F = seen.information(np.stack(columns, -1), mounts)
    scale = 1 / np.sqrt(np.maximum(np.diagonal(F), 1e-30))
    values, vectors = np.linalg.eigh(F * np.outer(scale, scale))
    variance = (vectors**2 / np.maximum(values, 1e-12)).sum(axis=1) * scale**2
    std, found = np.sqrt(variance), {}
    for key, shape in zip(keys, shapes, strict=True):
        size = int(np.prod(shape))
        found[key], std = std[:size].reshape(shape), std[size:]
    return found
