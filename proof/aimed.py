"""Effects drawn to a wanted visibility: so many times the Cramer-Rao bound, see `bounds`."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from imubench.proof.bounds import visibility
from imubench.proof.case import build
from imubench.proof.filed import write
from imubench.proof.options import Effect
from imubench.proof.played import Case, played
from imubench.proof.rotation import Parameters
from imubench.proof.sight import Sight, sight
from imubench.proof.told import truth

POWERS = {  # of the parameters that make an effect larger
    **dict.fromkeys(("bias", "rate", "scale", "matrix", "offset", "skew", "amplitude", "rotation", "translation"), 1.0),
    **dict.fromkeys(("slide", "twist", "range", "coupling", "std", "peak", "jump", "share", "factor", "width"), 1.0),
    **{"cutoff": -1.0, "frequency": -0.5, "limit": -0.3, "span": -0.5},
}
FIXED = {"vibration": ("frequency",), "hysteresis": ("width",)}  # these do not belong to the effect's size
LARGEST, SMALLEST = 300.0, 1e-3  # of the factor on what was drawn
CLOSE = 0.05  # of the wanted visibility
RUNAWAY = 1e6  # times it: of an effect so large that its motion has no bound
ATTEMPTS = 14


def sized(effect: Effect, factor: float, gravity: float) -> Effect:
    """Return an effect `factor` times as large."""
    found: Parameters = {}
    for key, value in effect.parameters.items():
        if key == "g":
            found[key] = gravity + factor * (value - gravity)
        elif key in POWERS and key not in FIXED.get(effect.effect, ()):
            found[key] = np.asarray(value, dtype=float) * factor ** POWERS[key]
            found[key] = found[key] if found[key].ndim else float(found[key])
        else:
            found[key] = value
    return replace(effect, parameters=found)


def aimed(effect: Effect, case: Case, seen: Sight, wanted: float) -> tuple[Effect, float]:
    """Return the effect at `wanted` times its bound, alone in `case`'s motion, and the visibility that it has.

    By secants and bisections on the logarithms; where no size within reason gets there, the nearest that was tried.
    """

    def visible(factor: float) -> float:
        case_there = replace(case, effects=[sized(effect, factor, case.options.gravity)])
        try:
            return max(visibility(case_there, seen) or 0.0, 1e-6)
        except FloatingPointError:  # its motion runs away
            return RUNAWAY * wanted

    return _reached(effect, case.options.gravity, visible, wanted)


def _reached(effect: Effect, gravity: float, visible: Callable[[float], float], wanted: float) -> tuple[Effect, float]:
    tried: list[tuple[float, float]] = []  # log factor, log of visibility over wanted
    x, slope = 0.0, 1.0
    for attempt in range(ATTEMPTS):
        tried.append((x, float(np.log(visible(float(np.exp(x))) / wanted))))
        best = min(tried, key=lambda pair: abs(pair[1]))
        if abs(best[1]) < CLOSE:
            break
        below = max((pair for pair in tried if pair[1] < 0), default=None)
        above = min((pair for pair in tried if pair[1] > 0), default=None)
        if below and above:
            share = 0.5 if below[1] < -3 or attempt % 2 else below[1] / (below[1] - above[1])
            x = below[0] + share * (above[0] - below[0])
        else:
            if len(tried) > 1 and tried[-1][0] != tried[-2][0]:
                slope = (tried[-1][1] - tried[-2][1]) / (tried[-1][0] - tried[-2][0])
            x = best[0] + float(np.clip(-best[1] / float(np.clip(slope, 0.3, 6.0)), -2.5, 2.5))
            x = float(np.clip(x, np.log(SMALLEST), np.log(LARGEST)))
        if x in [pair[0] for pair in tried]:
            break
    return sized(effect, float(np.exp(best[0])), gravity), wanted * float(np.exp(best[1]))


def make_aimed(
    out: Path, rig: str, effects: Any, seed: int, wanted: list[float | None], strength: str = "medium", **options: Any
) -> dict[str, Any]:
    """Write a case whose effects have the `wanted` visibilities, each taken alone, and return its truth.

    None: as `make_case` draws it. So is an effect for which visibility has no meaning: in a free swing, or a fault
    without a mean. The truth says under `visibility` what each has, None where that has no meaning.
    """
    case = build(rig, effects, seed, strength, **options)
    seen, chosen, reached = sight(case), [], []
    for effect, want in zip(case.effects, wanted, strict=True):
        alone = replace(case, effects=[effect])
        has = visibility(alone, seen) if seen is not None else None
        if seen is not None and has is not None and want is not None:
            effect, has = aimed(effect, alone, seen, want)
        chosen.append(effect)
        reached.append(has)
    case = played(case.options, chosen, seed)
    write(case, out)
    return truth(case) | {"visibility": reached}
