"""Roll-outs of one recording, each made once: many numbers change how a motion is read, and few how a rig swings.

A roll-out has three parts: MuJoCo integrates the rig, the sensors are carried along by that motion, and what they read
is compared. The first takes most of the time, and only weight, torques and the body enter it: neither a mount, for
sensors weigh nothing there, nor a sensor's error. So what was made last is kept by all that enters it.
"""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np

from imubench.diagnosis.config.solve import ALGEBRA
from imubench.diagnosis.evidence import Played, Swing
from imubench.diagnosis.simulation.rollout import rolled_out, with_weightless_sensors
from imubench.diagnosis.simulation.sim_model import SimModel
from imubench.diagnosis.simulation.splice import carried
from imubench.sim.rigs import Rig, standard_rig
from imubench.truth import Truth

T = TypeVar("T")


class Latest:
    """What was made last, by what it was made of: as many numbers as stay in the cache, the last one anyhow."""

    def __init__(self) -> None:
        self.made: OrderedDict[Hashable, tuple[Any, int]] = OrderedDict()
        self.numbers = 0

    def of(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what was made of `key`, made now where it was not."""
        if key not in self.made:
            value = make()
            self.made[key] = value, size_of(value)
            self.numbers += self.made[key][1]
            while len(self.made) > 1 and self.numbers > ALGEBRA.chunk_numbers:
                self.numbers -= self.made.popitem(last=False)[1][1]
        self.made.move_to_end(key)
        found: T = self.made[key][0]
        return found


class RollOuts:
    """The roll-outs of models beside one recording, at one rate."""

    def __init__(self, rate: float, step: float) -> None:
        self.rate, self.step = rate, step  # Hz of rows, s of the integration at most
        self.motions, self.truths = Latest(), Latest()

    def motion(self, rig: Rig, window: Swing) -> Played:
        """Return the motion of a rig by forces alone; `InputError` as `rolled_out` raises it."""
        bare = with_usual_sensors(rig)
        return self.motions.of(key_of((bare, window)), lambda: rolled_out(bare, window, self.rate, self.step))

    def truth(self, model: SimModel, window: Swing, angle_alone: bool = False) -> Truth:
        """Return MuJoCo's truth of a model's window, where nothing else is read of the hinge's `angle_alone`."""
        rig, motion = model.rig, self.motion(model.rig, window)
        if angle_alone:
            rows = int((window.end - window.start) * self.rate + 1e-6) + 1
            angle = None if motion.hinge_angle is None else motion.hinge_angle[:rows]
            return Truth(np.arange(rows) / self.rate, rig.family, rig.gravity, (), (), angle)
        if rig.loose is not None:  # it turns as the fit's own motion tells
            return carried(rig, motion, window, self.rate, model.start, told=model.motion)
        key = key_of((rig, window, model.start))
        return self.truths.of(key, lambda: carried(rig, motion, window, self.rate, model.start))


def with_usual_sensors(rig: Rig) -> Rig:
    """Return a rig as it is integrated, weightless sensors where its file has them: where they sit moves nothing."""
    return with_weightless_sensors(replace(rig, mounts=standard_rig(rig.family).mounts))


def key_of(value: object) -> Hashable:
    """Return what tells a record from one with other numbers; of what is no record, number or array: itself."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if is_dataclass(value):
        return type(value), *(key_of(getattr(value, f.name)) for f in fields(value))
    return tuple(map(key_of, value)) if isinstance(value, tuple) else value


def size_of(value: object) -> int:
    """Return how many numbers the arrays of a record have."""
    if isinstance(value, np.ndarray):
        return int(value.size)
    if is_dataclass(value):
        return sum(size_of(getattr(value, f.name)) for f in fields(value))
    return sum(map(size_of, value)) if isinstance(value, tuple) else 0


__all__ = ["Latest", "RollOuts", "key_of", "with_usual_sensors"]
