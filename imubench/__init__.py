"""A test bench for inertial joint calibration.

::

    import imubench as ib

    recording, truth = ib.simulate("hinge-hand", seed=1)
    estimate = ib.estimate("olsson2020", recording)
    ib.score(estimate, truth).figures

docs/library.md lists what `ib` has. Nothing else is imported until one of its names is used.

Data flows one way::

    scenario -> simulate -> Truth -> observe -> Recording -> estimate -> Estimate -> score -> log

A `Recording` from a laboratory and one from the simulator are the same type.
Estimators see a `Recording` and nothing else; `Truth` only judges them.

Conventions, the same everywhere
--------------------------------
Units       SI and radians. Another unit appears only in a name at the border
            (``rate_deg_s``).
Quaternions ``w, x, y, z``; ``q_ws`` turns sensor coordinates into world
            coordinates, and so does the rotation matrix ``R_ws``.
World       z up, gravity (0, 0, -9.81) m/s^2 unless a recording says otherwise.
Accelerometer  reads specific force ``f = R_ws^T (a - g)``: at rest it points up.
Gyroscope   reads the angular rate of the sensor in sensor axes.
Hinge rig   both segment frames have their origin in the joint centre and +y along
            the hinge axis; segment 1 extends along -x, segment 2 along +x. The
            hinge angle turns segment 2 relative to segment 1 about +y.
Pendulum    the segment frame has its origin in the pivot; at rest the limb hangs
            along -z.
Mount       (position of the sensor in the segment frame, quaternion sensor -> segment).
Joint vector ``r`` points from the sensor to the joint centre, in the sensor frame.
Suffixes    ``_s`` in sensor axes, ``_b`` in segment axes, ``_w`` in world axes;
            ``_std`` per sample, ``_density`` per root hertz.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from imubench.diagnosis.result import Diagnosis
    from imubench.errors import InputError
    from imubench.estimate import Estimate
    from imubench.library import check, diagnose, load, load_reference, observe, sweep
    from imubench.listing import known
    from imubench.recording import Imu, Recording
    from imubench.reference import Reference
    from imubench.run import estimate, simulate
    from imubench.score import Score, score
    from imubench.truth import Truth

__version__ = "0.1.0"
__all__ = [
    "Diagnosis",
    "Estimate",
    "Imu",
    "InputError",
    "Recording",
    "Reference",
    "Score",
    "Truth",
    "check",
    "diagnose",
    "estimate",
    "known",
    "load",
    "load_reference",
    "observe",
    "score",
    "simulate",
    "sweep",
]

PUBLIC = {
    "load": "imubench.library",
    "load_reference": "imubench.library",
    "simulate": "imubench.run",
    "observe": "imubench.library",
    "estimate": "imubench.estimate",  # the module, which is called as imubench.run.estimate
    "score": "imubench.score",  # the module, which is called as its score
    "diagnose": "imubench.library",
    "sweep": "imubench.library",
    "check": "imubench.library",
    "known": "imubench.listing",
    "Recording": "imubench.recording",
    "Imu": "imubench.recording",
    "Truth": "imubench.truth",
    "Reference": "imubench.reference",
    "Estimate": "imubench.estimate",
    "Score": "imubench.score",
    "Diagnosis": "imubench.diagnosis.result",
    "InputError": "imubench.errors",
}
"""The names of the library and the modules that have them: one more is one line here, in `__all__` and above."""


if not TYPE_CHECKING:  # which shall complain of a name that is none

    def __getattr__(name: str) -> Any:
        if name not in PUBLIC:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        module = import_module(PUBLIC[name])
        if module.__name__ == f"{__name__}.{name}":
            return module  # one that is called
        found = getattr(module, name)
        globals()[name] = found
        return found


def __dir__() -> list[str]:
    return sorted([*__all__, *(name for name in globals() if name.startswith("__"))])
