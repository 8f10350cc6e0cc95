"""A diagnosis as it stands in diagnosis.json."""

from collections.abc import Mapping
from typing import Any

from imubench.diagnosis.result import (
    Change,
    Diagnosis,
    Finding,
    Moves,
    Nonsense,
    Own,
    Parameter,
    Rejected,
    SensorErrors,
    Simulation,
    Where,
)

FILE_NAME = "diagnosis.json"
FORMAT = 1
MISFIT_UNIT = "residual power over noise power, 1 = only noise"


def as_dict(d: Diagnosis) -> dict[str, Any]:
    """Return the content of diagnosis.json.

    "simulation", "moves", "doubts", "unseen", "nonsense", "stopped" with "not_tried", "sensors", "baseline" and a
    finding's "where" stand in it only where there are any.
    """
    content: dict[str, Any] = {
        "format": FORMAT,
        "recording": d.recording,
        "rig": d.rig,
        "verdict": d.verdict,
        "alarm": d.alarm,
        "tolerance": {"deg": float(d.tolerance[0]), "mm": float(d.tolerance[1])},
        "misfit": {"nominal": float(d.misfit[0]), "explained": float(d.misfit[1]), "unit": MISFIT_UNIT},
        "where": [_where(w) for w in d.where],
        "findings": [_finding(f) for f in d.findings],
        "rejected": [_rejected(r) for r in d.rejected],
        "noise": {name: {"std": float(n.std), "unit": n.unit, "source": n.source} for name, n in d.noise.items()},
        "fit": {
            "heldout": {"before": float(d.fit.heldout[0]), "after": float(d.fit.heldout[1])},
            "left_out_channel": _change(d.fit.left_out_channel),
            "reference": _change(d.fit.reference),
        },
        "model": d.model,
        "seconds": round(float(d.seconds), 3),
    }
    if d.simulation is not None:
        content["simulation"] = simulation_as_dict(d.simulation)
    if d.moves:
        content["moves"] = _moves(d.moves)
    if d.doubts:
        content["doubts"] = [{"of": doubt.of, "why": doubt.why} for doubt in d.doubts]
    if d.unseen:
        content["unseen"] = [{"what": u.what, "motion": u.motion} for u in d.unseen]
    if d.nonsense:
        content["nonsense"] = [_nonsense(n) for n in d.nonsense]
    if d.stopped:
        content |= {"stopped": d.stopped, "not_tried": list(d.not_tried)}
    if d.sensors:
        content["sensors"] = [_sensor(s) for s in d.sensors]
    if d.baseline is not None:
        taken = [_own(o) | {"at": o.at} for o in d.baseline.taken_over]
        content["baseline"] = {"recording": d.baseline.recording, "taken_over": taken}
        if d.baseline.doubt:
            content["baseline"]["doubt"] = d.baseline.doubt
    return content


def _moves(moves: Moves) -> dict[str, Any]:
    return {name: {"value": m.value.tolist(), "unit": m.unit} for name, m in moves.items()}


def simulation_as_dict(s: Simulation) -> dict[str, Any]:
    """Return how far MuJoCo's simulations are from a recording, as diagnosis.json has it."""
    channels = {
        name: {"unit": c.unit, "before": float(c.before), "after": float(c.after), "noise": float(c.noise)}
        | ({} if c.fit is None else {"fit": float(c.fit)})
        for name, c in s.channels.items()
    }
    windows = [[float(start), float(end)] for start, end in s.windows_s]
    return {"how": s.how, "windows_s": windows, "heldout": bool(s.heldout), "channels": channels}


def _nonsense(n: Nonsense) -> dict[str, Any]:
    content: dict[str, Any] = {"at": n.at, "what": n.what, "channels": list(n.channels), "advice": n.advice}
    return content | {"evidence": {name: float(v) for name, v in n.evidence.items()}, "missing": n.missing}


def _where(w: Where) -> dict[str, Any]:
    return {
        "at": w.at,
        "channels": {name: float(share) for name, share in w.channels.items()},
        "bands_hz": [list(band) for band in w.bands_hz],
        "windows_s": [list(window) for window in w.windows_s],
        "depends_on": w.depends_on,
        "share": float(w.share),
    }


def _parameters(parameters: Mapping[str, Parameter]) -> dict[str, Any]:
    return {name: {"value": p.value.tolist(), "std": p.std.tolist(), "unit": p.unit} for name, p in parameters.items()}


def _own(o: Own) -> dict[str, Any]:
    return {"effect": o.effect, "parameters": _parameters(o.parameters)}


def _sensor(s: SensorErrors) -> dict[str, Any]:
    return {
        "at": s.at,
        "rate": float(s.rate),
        "ranges": {part: float(limit) for part, limit in s.ranges.items()},
        "errors": [_own(o) for o in s.errors],
        "correlation": s.correlation.tolist(),
    }


def _finding(f: Finding) -> dict[str, Any]:
    gain = f.heldout_gain
    content: dict[str, Any] = {
        "effect": f.effect,
        "at": f.at,
        "confidence": float(f.confidence),
        "parameters": _parameters(f.parameters),
        "heldout_gain": {"value": float(gain.value), "ci": list(gain.ci), "unit": gain.unit},
        "equivalent": [_rejected(e) for e in f.equivalent],
        "separate_by": f.separate_by,
        "moves": _moves(f.moves),
        "material": bool(f.material),
    }
    if f.share is not None:
        content["share"] = float(f.share)
    if f.unseen:
        content["unseen"] = list(f.unseen)
    return content if f.where is None else content | {"where": _where(f.where)}


def _rejected(r: Rejected) -> dict[str, Any]:
    return {"effect": r.effect, "at": r.at, "heldout_gain": float(r.heldout_gain)}


def _change(c: Change) -> dict[str, Any]:
    before, after = ({name: float(v) for name, v in side.items()} for side in (c.before, c.after))
    return {"before": before, "after": after, "unit": c.unit}
