"""Where a mount lies that is far from where it is declared: how it sees the joint's centre, whatever the angle.

With p where a sensor is on its segment, from the joint's centre, f what it reads and w how it turns, all in the axes of
the segment, what the centre reads is f - K p, with K p = w' x p + w x (w x p) (`estimators.hinge_position`). Seen by
both IMUs it is equally long, |f_1 - K_1 p_1| = |f_2 - K_2 p_2|: least squares over the one p that is sought, from where
it is declared. A sensor that is both turned and moved by far is found only if its place is sought after its turn: each
alone leaves the fit in another minimum.
"""

import numpy as np
from scipy.optimize import least_squares

from imubench.arrays import Array
from imubench.diagnosis.config.candidates import MOUNT_START
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.solve.clock_offsets import late, on_segments
from imubench.estimators.hinge_position import STENCIL, angular_acceleration, lever_matrices, residuals


def far_lever_arm(model: Model, at: str) -> Array | None:
    """Return by how much (3,) m, in the segment's axes, an IMU lies from where it is declared, one of a hinge's two.

    None where the other IMU is not there, or nothing is seen.
    """
    imus = model.recording.imus
    if not model.rig.turns or len(imus) != 2:
        return None
    period = 1 / min(i.rate for i in imus)
    grid = np.arange(max(i.time[0] for i in imus), min(i.time[-1] for i in imus), period) - model.start
    if len(grid) < len(STENCIL):
        return None
    read = on_segments(model, grid, late(model)).values()
    inner = slice(len(STENCIL) // 2, -(len(STENCIL) // 2))
    levers = np.stack([lever_matrices(rate[inner], angular_acceleration(rate, period)) for rate, _ in read])
    accel = np.stack([force[inner] for _, force in read])
    centre = -np.stack([model.mounts[i.name].position for i in imus])  # (2, 3) m, as seen from the sensors
    which = [i.name for i in imus].index(at)
    own = slice(3 * which, 3 * which + 3)

    def stacked(p: Array) -> Array:
        return np.concatenate([p if n == which else c for n, c in enumerate(centre)])

    done = least_squares(
        lambda p: residuals(stacked(p), accel, levers)[0],
        centre[which],
        jac=lambda p: residuals(stacked(p), accel, levers)[1][:, own],
        loss="soft_l1",
        x_scale=0.1,
    )
    moved = centre[which] - done.x
    return moved if np.linalg.norm(moved) < MOUNT_START.reach_m else None


__all__ = ["far_lever_arm"]
