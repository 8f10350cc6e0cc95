"""A hinge with dry friction that turns over in the moment in which the joint does.

About the hinge, with s the direction in which it turns and M all other torque on it::

    I q'' = M(q, q') - t s        s = sign q'
    q'' = 0                       where q' = 0 and M - t s turns it in neither direction s: it sticks

MuJoCo's `frictionloss` is a constraint that stops the joint within a step, so what a roll-out says is off by as much as
a step is long, and jumps where one more step fits before a reversal: its derivatives by a friction or a start are lost
in these jumps. Between two reversals -t s is constant and all is smooth. So it is applied as a torque that does not
change within a step; where a step of Runge and Kutta's rule ends with the other sign of q', the step is shortened until
it ends with q' = 0, and the rest of it goes in the direction in which the joint turns then.
"""

from dataclasses import replace

import mujoco
import numpy as np

from imubench.arrays import Array
from imubench.errors import InputError
from imubench.sim.compile import compile_model
from imubench.sim.rigs import Rig
from imubench.sim.stability import check_finite
from imubench.sim.swing import Start, Torque, initial_state

STILL = 1e-12  # of the rate at a step's begin, that is left of it at a reversal: rounding


class _Hinge:
    """A hinge on a base that stands still, as MuJoCo integrates it."""

    def __init__(self, rig: Rig, start: Start, step: float) -> None:
        self.model = compile_model(replace(rig, dry_friction=0.0), step, integrator="RK4")
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_SENSOR)  # nobody reads them here
        self.data, self.friction, self.step = mujoco.MjData(self.model), rig.dry_friction, step
        self.qpos, self.qvel, self.pushed = self.data.qpos, self.data.qvel, self.data.qfrc_applied  # live arrays
        self.qpos[:], self.qvel[:] = initial_state(self.model, rig.tree, start)
        assert rig.tree.hinge is not None
        joint = self.model.joint(rig.tree.hinge.name)
        self.dof, self.place = int(joint.dofadr[0]), int(joint.qposadr[0])
        self.begun = self.qpos.copy(), self.qvel.copy()  # the state that a step began with
        self.side = float(np.sign(self.qvel[self.dof]))  # 0: it sticks, or starts from rest

    def advance(self, torque: float) -> None:
        """Move by a step under a torque N m besides what the rig has."""
        rest = self.step
        while rest > 0:
            self.side = self.side or self.turns(torque)
            if not self.side:
                return
            self.begun[0][:], self.begun[1][:] = self.qpos, self.qvel
            self.pushed[self.dof] = torque - self.friction * self.side
            mujoco.mj_step(self.model, self.data)
            if self.qvel[self.dof] * self.side >= 0:
                break
            rest -= self.reversed(rest)
            self.qvel[self.dof], self.side = 0.0, 0.0
            self.model.opt.timestep = rest
        self.model.opt.timestep = self.step

    def turns(self, torque: float) -> float:
        """Return the sign of the rate with which a joint goes on that stands; 0 where it sticks."""
        for side in (1.0, -1.0):
            self.pushed[self.dof] = torque - self.friction * side
            mujoco.mj_forward(self.model, self.data)
            if self.data.qacc[self.dof] * side > 0:
                return side
        return 0.0

    def reversed(self, step: float) -> float:
        """Move from where a step of some s began until the rate is zero; return after how long, s.

        By regula falsi, the end that stays weighed half (the Illinois rule); the rate is next to straight in a step.
        """
        low, high = 0.0, step
        before, after = float(self.begun[1][self.dof]), float(self.qvel[self.dof])
        enough = STILL * max(abs(before), abs(after))
        while True:
            middle = low + (high - low) * before / (before - after)
            self.qpos[:], self.qvel[:] = self.begun
            self.model.opt.timestep = middle
            mujoco.mj_step(self.model, self.data)
            rate = float(self.qvel[self.dof])
            if abs(rate) <= enough or not low < middle < high:
                return middle
            if rate * self.side > 0:
                low, before, after = middle, rate, after / 2
            else:
                high, after, before = middle, rate, before / 2


def swing_dry_hinge(
    rig: Rig, start: Start, rows: int, split: int, step: float, torque: Torque | None = None
) -> tuple[Array, Array]:
    """Return the angles (rows,) rad and rates (rows,) rad/s of a hinge that is let go.

    Args:
        rig: a hinge on a base that stands still, its sensors sitting fast.
        start: its state in the first row.
        rows: how many.
        split: steps to a row.
        step: s, of the integration.
        torque: N m about the hinge at seconds (n,) since the start, held throughout a step; besides what the rig has.

    Raises:
        InputError: for a rig that moves otherwise, or a simulation that does not stay finite.
    """
    if rig.tree.hinge is None or not rig.clamped or any(mount.moves for mount in rig.mounts):
        raise InputError("dry hinge: expected a hinge on a fixed base with sensors that sit fast, got another rig")
    swing, out, steps = _Hinge(rig, start, step), np.empty((rows, 2)), rows * split
    given: list[float] = [0.0] * steps if torque is None else torque(np.arange(0.0, steps) * step).tolist()
    for k in range(steps):
        if k % split == 0:
            out[k // split] = swing.qpos[swing.place], swing.qvel[swing.dof]
        swing.advance(given[k])
    check_finite(swing.data, "roll-out")
    return out[:, 0], out[:, 1]


__all__ = ["swing_dry_hinge"]
