"""The truth about a case, as JSON can hold it."""

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from imubench.proof.options import Effect
from imubench.proof.played import Case
from imubench.proof.ranges import twins
from imubench.proof.rotation import to_quaternion

DETAIL = ("kind", "peak")


def truth(case: Case) -> dict[str, Any]:
    """Return what is true of a case, as JSON can hold it."""
    return {
        "format": 1,
        "seed": case.seed,
        "rig": case.options.rig,
        "effects": [told(e) for e in case.effects],
        "equivalent": [told(e) for e in twins(case.effects, case.options)],
        "mounts": [
            {"position": plain(m.position), "quaternion": plain(to_quaternion(m.rotation))} for m in case.mounts
        ],
        "options": plain(asdict(case.options)),
    }


def told(effect: Effect) -> dict[str, Any]:
    """Return an effect as JSON can hold it; `detail` has what the table of effects does not name as a parameter."""
    parameters = dict(effect.parameters)
    detail = {key: parameters.pop(key) for key in DETAIL if key in parameters}
    return plain(asdict(replace(effect, parameters=parameters)) | {"detail": detail})


def plain(value: Any) -> Any:
    """Return a value with arrays as lists and NumPy's numbers as Python's."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value.item() if isinstance(value, np.generic) else value
