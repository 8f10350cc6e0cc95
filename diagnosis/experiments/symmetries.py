"""Effects that no motion tells apart: the same readings follow from either, so there is nothing to record.

A linear prediction of a motion's information does not see that: the splines of a planned motion cannot follow a clock
that is moved by part of a knot's interval, and the difference looks like information.
"""

from collections.abc import Callable
from dataclasses import dataclass

from imubench.diagnosis.experiments.motion_menu import Motion
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.traits import CLOCKS
from imubench.recording import Recording


@dataclass(frozen=True)
class Symmetry:
    """Two effects at their places of which each has the other's readings, where a recording is of some kind."""

    why: str
    same: Callable[[Hypothesis, Hypothesis], bool]  # in one order of the two
    where: Callable[[Recording], bool] = lambda _: True
    swings: bool = True  # whether it holds in free swings, too

    def joins(self, one: Hypothesis, other: Hypothesis, recording: Recording, motion: Motion | None = None) -> bool:
        """Return whether a recording of this kind, of a motion if one is given, cannot tell two effects apart."""
        free = motion is not None and any(stage.free for stage in motion.stages)
        pair = self.same(one, other) or self.same(other, one)
        return pair and self.where(recording) and (self.swings or not free)


def _are(first: str, second: str) -> Callable[[Hypothesis, Hypothesis], bool]:
    """Return whether two effects are of these names, each NAME@PLACE or NAME at any place."""

    def is_one(h: Hypothesis, text: str) -> bool:
        name, _, at = text.partition("@")
        return h.effect.name == name and at in ("", h.at)

    return lambda one, other: is_one(one, first) and is_one(other, second)


def _clocks(one: Hypothesis, other: Hypothesis) -> bool:
    """Return whether two effects are the same error of two clocks."""
    return one.effect.name == other.effect.name and one.effect.name in CLOCKS and one.at != other.at


def _only_imus(recording: Recording) -> bool:
    return not (recording.encoders or recording.poses)


ALWAYS: tuple[Symmetry, ...] = (
    Symmetry("a common shift of both clocks only says when the motion was", _clocks, _only_imus),
    Symmetry(
        "the second segment seen from the first sensor moves alike",
        _are("moving_centre@joint", "skin_sliding@imu1"),
        lambda recording: recording.base == "free",
    ),
    Symmetry(
        "a turn that follows the hinge angle, before or after the sensor",
        _are("axis_coupling@joint", "skin_sliding@imu2"),
    ),
)
"""That hold whatever the motion."""

BUT_IN_SWINGS: tuple[Symmetry, ...] = (
    Symmetry(
        "a scale that all accelerometers share is another unit of force",
        _are("gravity@world", "accel_scale"),
        swings=False,
    ),
)
"""That hold but in free swings, whose time gravity sets."""

__all__ = ["ALWAYS", "BUT_IN_SWINGS", "Symmetry"]
