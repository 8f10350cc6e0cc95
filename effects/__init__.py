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
from imubench.recording import Recording

VARIANTS: tuple[Effect, ...] = (
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
"""Every effect with every choice of its settings: what a diagnosis tries."""

EFFECTS: dict[str, Effect] = dict(reversed({e.name: e for e in reversed(VARIANTS)}.items()))
"""The effects by name, each with the first of its settings."""


def possible(recording: Recording) -> list[tuple[Effect, str]]:
    """Return every effect that a fit can hold, suited to a recording, at every place where it could act."""
    fitted = (e for e in VARIANTS if e.parameters or e.states)
    return [(effect.suited(recording), at) for effect in fitted for at in effect.places(recording)]


__all__ = ["EFFECTS", "VARIANTS", "Effect", "possible"]
