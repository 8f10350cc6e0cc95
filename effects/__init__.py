"""Left-out physics: one file per family, one definition per law, one line to register it."""

from imubench.effects import (
    bandwidth,
    joints,
    mounts,
    play,
    samples,
    sensor_errors,
    soft_mounts,
    timing,
    torques,
    vibration,
)
from imubench.effects.effect import Effect
from imubench.effects.library import ByName, Library
from imubench.effects.traits import Traits
from imubench.recording import Recording

VARIANTS = Library(
    (
        *sensor_errors.EFFECTS,
        *timing.EFFECTS,
        *bandwidth.EFFECTS,
        *mounts.EFFECTS,
        *soft_mounts.EFFECTS,
        *play.EFFECTS,
        *joints.EFFECTS,
        *torques.EFFECTS,
        *vibration.EFFECTS,
        *samples.EFFECTS,
    )
)
"""Every effect with every choice of its settings: what a diagnosis tries."""

EFFECTS = ByName(VARIANTS)
"""The effects by name, each with the first of its settings."""


def traits_of(name: str) -> Traits:
    """Return what is declared of the effect of a name; of what no law explains, that nothing is."""
    return EFFECTS.traits(name)


def possible(recording: Recording) -> list[tuple[Effect, str]]:
    """Return every effect that a fit can hold, suited to a recording, at every place where it could act."""
    fitted = (e for e in VARIANTS if e.parameters or e.states)
    return [(effect.suited(recording), at) for effect in fitted for at in effect.places(recording)]


def filter_law() -> Effect | None:
    """Return the first filter of the library; None where it has none."""
    return EFFECTS.first(lambda e: e.filters)


def delay_law() -> Effect:
    """Return the law of a clock that is late by a constant, which a fit may begin with, in the library or not."""
    return EFFECTS.whichever(lambda e: e.late_by)


__all__ = ["EFFECTS", "VARIANTS", "Effect", "delay_law", "filter_law", "possible", "traits_of"]
