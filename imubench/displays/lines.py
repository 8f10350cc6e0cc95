"""A recording, a truth and their parts in one line each."""

from collections.abc import Callable
from typing import Any

from imubench.arrays import Array
from imubench.recording import Encoder, Imu, Pose, Recording, span_of
from imubench.reference import Reference
from imubench.truth import SegmentTruth, SensorTruth, Truth


def line(value: Any) -> str:
    """Return a value in one line, without its arrays."""
    return f"<{LINES[type(value)](value)}>" if type(value) in LINES else object.__repr__(value)


def _recording(r: Recording) -> str:
    start, end = span_of(r)
    parts = [f"{imu.name} {imu.time.size:,} samples at {imu.rate:g} Hz" for imu in r.imus]
    parts += [f"encoder of the {e.joint}" for e in r.encoders] + [f"pose of {p.segment}" for p in r.poses]
    swings = f", {len(r.free_swings)} free swings" if r.free_swings else ""
    return f"Recording {r.name!r}: {r.rig}, {_span(start, end)}, {', '.join(parts)}{swings}"


def _truth(t: Truth) -> str:
    names = ", ".join([*(segment.name for segment in t.segments), *(sensor.name for sensor in t.sensors)])
    angle = ", hinge angle" if t.joint_angle is not None else ""
    return f"Truth: {t.rig}, {_rows(t.time)} of {names}{angle}"


def _imu(i: Imu) -> str:
    return f"Imu {i.name!r}: {_rows(i.time)} at {i.rate:g} Hz"


def _encoder(e: Encoder) -> str:
    return f"Encoder of the {e.joint}: {_rows(e.time)}"


def _pose(p: Pose) -> str:
    kinds = " and ".join(key for key in ("position", "quaternion") if getattr(p, key) is not None)
    return f"Pose of {p.segment}: {kinds}, {_rows(p.time)}"


def _reference(r: Reference) -> str:
    kinds = [key for key in ("hinge_angle", "quaternion1", "quaternion2", "joint_position") if _has(r, key)]
    return f"Reference: {', '.join(kinds)}, {_rows(r.time)}"


def _segment(s: SegmentTruth) -> str:
    return f"SegmentTruth {s.name!r}: {len(s.quaternion):,} rows"


def _sensor(s: SensorTruth) -> str:
    return f"SensorTruth {s.name!r}: {len(s.quaternion):,} rows"


def _has(value: object, key: str) -> bool:
    return getattr(value, key) is not None


def _rows(time: Array) -> str:
    return f"{time.size:,} samples, {_span(float(time[0]), float(time[-1]))}"


def _span(start: float, end: float) -> str:
    return f"{start:.6g} to {end:.6g} s"


LINES: dict[type, Callable[[Any], str]] = {
    Recording: _recording,
    Truth: _truth,
    Imu: _imu,
    Encoder: _encoder,
    Pose: _pose,
    Reference: _reference,
    SegmentTruth: _segment,
    SensorTruth: _sensor,
}
"""How each type is told."""
