"""MuJoCo Warp in place of `mujoco.batch` for the samples of driven joints; needs the extra `warp`.

It works in single precision: where it differs from MuJoCo's double by how much is in docs/simulation.md. Nothing in the
project depends on it, and datasets, whose bytes are the same everywhere, do not use it.
"""

from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.sim.compile import DRIVEN_ARMATURE

CHUNK = 8192  # samples on the device at once


def evaluate(model: Any, qpos: Array, qvel: Array, qacc: Array, device: str | None = None) -> Array:
    """Return what `driven.evaluate` returns, (n, nsensordata), from MuJoCo Warp.

    `device` is one of Warp's, "cpu" or "cuda:0"; None: its first choice. Raises `InputError` without the extra.
    """
    try:
        import mujoco_warp
        import warp
    except ImportError:
        raise InputError("engine 'warp': expected the extra, pip install 'imubench[warp]'; it is not there") from None
    n = len(qpos)
    size = min(CHUNK, n)
    found = np.empty((n, model.nsensordata))
    with warp.ScopedDevice(device):
        on_device, state = mujoco_warp.put_model(model), mujoco_warp.make_data(model, nworld=size)
        for start in range(0, n, size):
            part = slice(min(start, n - size), min(start, n - size) + size)
            told = {"qpos": qpos[part], "qvel": qvel[part], "qfrc_applied": DRIVEN_ARMATURE * qacc[part]}
            for key, rows in told.items():
                getattr(state, key).assign(np.ascontiguousarray(rows, dtype=np.float32))
            mujoco_warp.forward(on_device, state)
            found[part] = state.sensordata.numpy()
    return found
