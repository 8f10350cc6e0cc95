"""Left-out physics: one file per family, one definition per law, one line to register it."""

from imubench.effects import sensor_errors
from imubench.effects.effect import Effect

EFFECTS: dict[str, Effect] = {effect.name: effect for effect in (*sensor_errors.EFFECTS,)}

__all__ = ["EFFECTS", "Effect"]
