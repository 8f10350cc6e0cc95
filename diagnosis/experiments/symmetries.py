"""Effects that no motion tells apart: the same readings follow from either, so there is nothing to record.

A linear prediction of a motion's information does not see that: the splines of a planned motion cannot follow a clock
that is moved by part of a knot's interval, and the difference looks like information.
"""

from collections.abc import Iterator

from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.effects.traits import Alike
from imubench.recording import Recording


def same_readings(one: Hypothesis, other: Hypothesis, recording: Recording, swings: bool) -> bool:
    """Return whether the same readings follow from two effects at their places, whatever the motion.

    Args:
        one: an effect.
        other: what may stand in its place.
        recording: whose rig and sensors they are at.
        swings: whether that has to hold in free swings too, whose time gravity sets.
    """
    return any(holds(alike, recording, swings) for alike in (*declared(one, other), *declared(other, one)))


def declared(one: Hypothesis, other: Hypothesis) -> Iterator[Alike]:
    """Yield what an effect declares of being like another one, each at its place."""
    for alike in one.effect.alike:
        there = alike.other_at == other.at if alike.other_at else one.at != other.at
        if alike.effect == other.effect.name and alike.at in ("", one.at) and there:
            yield alike


def holds(alike: Alike, recording: Recording, swings: bool) -> bool:
    """Return whether that is so in a recording, and where asked for in free swings too."""
    measured = bool(recording.encoders or recording.poses)
    based = alike.base in ("", recording.base)
    return based and (alike.in_swings or not swings) and not (alike.only_imus and measured)


__all__ = ["same_readings"]
