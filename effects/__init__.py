"""Left-out physics: one file per family, one definition per law, one line to register it."""

from imubench.effects import joints, mounts, sensor_errors, soft_mounts, timing
from imubench.effects.effect import Effect

VARIANTS: tuple[Effect, ...] = (
    *sensor_errors.EFFECTS,
    *timing.EFFECTS,
    *mounts.EFFECTS,
    *soft_mounts.EFFECTS,
    *joints.EFFECTS,
)  # fmt: skip
"""Every effect with every choice of its settings: what a diagnosis tries."""

EFFECTS: dict[str, Effect] = {effect.name: effect for effect in reversed(VARIANTS)}
"""The effects by name, each with the first of its settings."""

__all__ = ["EFFECTS", "VARIANTS", "Effect"]
