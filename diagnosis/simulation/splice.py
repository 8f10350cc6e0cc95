"""Free swings that are rolled out, put into the truth of a motion that is prescribed around them."""

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from imubench.arrays import Array
from imubench.correction.replay import SplineMotion, dense_rows, truth_of_motion, with_play_of_motion
from imubench.correction.sensor_chain import Effects, moves_time
from imubench.diagnosis.config.correction import REPLAY
from imubench.diagnosis.config.simulation import ROLL_OUT
from imubench.diagnosis.evidence import Played, Swing
from imubench.diagnosis.simulation.rollout import rolled_out
from imubench.sim.play import play
from imubench.sim.rigs import Rig
from imubench.sim.swing import Torque
from imubench.truth import SegmentTruth, SensorTruth, Truth


def rolled_truth(
    rig: Rig,
    window: Swing,
    rate: float,
    start: float,
    first: float | None = None,
    step: float = ROLL_OUT.step_s,
    torque: Torque | None = None,
    told: Played | None = None,
) -> Truth:
    """Return MuJoCo's truth of a window that is rolled out, its sensors as they are carried along (`carried`).

    Args:
        rig: as it swings.
        window: a stretch of a free swing, the state at its start.
        rate: rows a second.
        start: s, that the rig's own times count from.
        first: s, of the first row, at most a row behind the window's start; None: there.
        step: s, of the integration at most.
        torque: N m at stamps (n,) s, besides what the rig has.
        told: see `carried`.
    """
    return carried(rig, rolled_out(rig, window, rate, step, torque), window, rate, start, first, told)


def carried(
    rig: Rig,
    motion: Played,
    window: Swing,
    rate: float,
    start: float,
    first: float | None = None,
    told: Played | None = None,
) -> Truth:
    """Return MuJoCo's truth of a window whose motion is rolled out.

    The window is integrated with its sensors sitting fast; what is sprung, slides or slips on the segment follows its
    motion. So does a limb that is loose in its joint: from which side to which it fell there no law foretells, so it
    turns as a recovered motion tells.

    Args:
        rig: whose motion it is.
        motion: from the window's start on.
        window: of it.
        rate: rows a second.
        start: s, that the rig's own times count from.
        first: s, of the first row, at most a row behind the window's start; None: there.
        told: a recovered motion, which may say how a limb turned in its play; None, or where it does not say: by its
            law.
    """
    first = window.start if first is None else first
    rows = int((window.end - first) * rate + 1e-6) + 1
    path = SplineMotion(motion, first, rig.gravity)
    loose = later(rig, first - start)
    loose = loose if told is None else with_play_of_motion(loose, told, first)
    return play(loose, path, (rows + 0.1) / rate, rate, threads=1)


def later(rig: Rig, seconds: float) -> Rig:
    """Return a rig whose clock begins `seconds` later: its mounts slip so much earlier by it."""
    slips = [m.slip and replace(m.slip, time=m.slip.time - seconds) for m in rig.mounts]
    return replace(rig, mounts=tuple(replace(m, slip=slip) for m, slip in zip(rig.mounts, slips, strict=True)))


def played(
    rig: Rig,
    motion: Played,
    effects: Effects,
    span: tuple[float, float],
    rate: float,
    windows: Sequence[Swing],
    torque: Torque | None = None,
) -> tuple[Truth, float]:
    """Return MuJoCo's truth of a motion with some windows of it rolled out, and the time of its first row in s.

    It goes from the first sample to the last. Where a clock is off it goes on at both ends, as far as the motion is
    known: what a late clock reads first was before that.

    Args:
        rig: whose own times count from the first sample.
        motion: that is prescribed.
        effects: of which some may move a sensor's time.
        span: s, of the samples.
        rate: rows a second, at least.
        windows: of free swings, with the state at the start of each.
        torque: see `rolled_truth`.
    """
    start, end = span
    dense, rows = dense_rows(rate), 0
    if moves_time(effects):
        rows = max(int((start - float(motion.time[0])) * dense), 0)
        end = max(end, float(motion.time[-1]) - REPLAY.end_rows / dense)
    first = start - rows / dense
    truth = truth_of_motion(later(rig, first - start), motion, first, end - first, rate)
    return with_swings(rig, truth, start, windows, torque, first, motion), first


def with_swings(
    rig: Rig,
    truth: Truth,
    start: float,
    windows: Sequence[Swing],
    torque: Torque | None = None,
    first: float | None = None,
    told: Played | None = None,
) -> Truth:
    """Return a truth with some windows rolled out; see `rolled_truth`. Without `first` its rows begin at `start`."""
    rate = 1 / float(truth.time[1] - truth.time[0])
    first = start if first is None else first
    pieces = []
    for window in windows:
        row = int(np.ceil((window.start - first) * rate - 1e-6))
        pieces.append((row, rolled_truth(rig, window, rate, start, first + row / rate, torque=torque, told=told)))
    return spliced(truth, pieces)


def from_row(truth: Truth, row: int) -> Truth:
    """Return a truth without its rows before one, its time counted from there."""

    def cut(part: SegmentTruth | SensorTruth | Truth) -> dict[str, Any]:
        arrays = {f.name: getattr(part, f.name) for f in fields(part)}
        return {name: x[row:] for name, x in arrays.items() if isinstance(x, np.ndarray) and len(x) == truth.time.size}

    return replace(
        truth,
        **cut(truth)
        | {
            "time": truth.time[: truth.time.size - row],
            "segments": tuple(replace(s, **cut(s)) for s in truth.segments),
            "sensors": tuple(replace(s, **cut(s)) for s in truth.sensors),
        },
    )


def spliced(truth: Truth, pieces: list[tuple[int, Truth]]) -> Truth:
    """Return a truth with others in place of its rows, each from a row on; all have as many rows a second."""
    if not pieces:
        return truth

    def joined(whole: Array | None, parts: list[Array | None]) -> Array | None:
        if whole is None:
            return None
        out = np.array(whole)
        for (first, _), part in zip(pieces, parts, strict=True):
            assert part is not None
            n = min(len(part), len(out) - first)
            out[first : first + n] = part[:n]
        return out

    def of(kind: type[SegmentTruth] | type[SensorTruth], group: str, k: int):  # type: ignore[no-untyped-def]
        whole = getattr(truth, group)[k]
        others = [getattr(piece, group)[k] for _, piece in pieces]
        names = [f.name for f in fields(kind) if f.name != "name"]
        return replace(whole, **{n: joined(getattr(whole, n), [getattr(o, n) for o in others]) for n in names})

    return replace(
        truth,
        segments=tuple(of(SegmentTruth, "segments", k) for k in range(len(truth.segments))),
        sensors=tuple(of(SensorTruth, "sensors", k) for k in range(len(truth.sensors))),
        joint_angle=joined(truth.joint_angle, [p.joint_angle for _, p in pieces]),
        joint_rate=joined(truth.joint_rate, [p.joint_rate for _, p in pieces]),
    )


__all__ = ["carried", "from_row", "later", "played", "rolled_truth", "spliced", "with_swings"]
