"""Simulations that run away end in one line; MuJoCo writes no log of them.

By default MuJoCo prints its warnings and appends them to MUJOCO_LOG.TXT in the current folder, whoever's that is. A
batch whose state is no longer finite stops there and repeats its last record, so its warnings are to be asked for.
"""

from functools import cache
from typing import Any

import mujoco

from imubench.errors import InputError

UNSTABLE = ("BADQPOS", "BADQVEL", "BADQACC")  # NaN, infinite or beyond 1e10


@cache
def write_no_log() -> None:
    """Keep MuJoCo's warnings out of files and off the terminal in this process; to be called before a model is made."""
    config = mujoco.MjLogConfig.get()
    config.logto_file = config.logto_console = False
    config.set()


def check_finite(data: Any, name: str) -> None:
    """Raise `InputError` where the simulation of an MjData did not stay finite; `name` says what it was."""
    if any(data.warning[int(getattr(mujoco.mjtWarning, f"mjWARN_{w}"))].number for w in UNSTABLE):
        raise runaway(name)


def check_stable(batch: Any, name: str) -> None:
    """Raise `InputError` where a simulation of a `mujoco.batch.Batch` did not stay finite; `name` says what it was."""
    counts = batch.warning[:, [int(getattr(mujoco.mjtWarning, f"mjWARN_{w}")) for w in UNSTABLE], 1]
    if counts.any():
        raise runaway(name)


def runaway(name: str) -> InputError:
    """Return what is raised where a simulation runs away."""
    return InputError(
        f"{name}: expected a simulation that stays finite, got one that does not: "
        "a spring, damper or torque is too strong for the time step"
    )
