"""One diagnosis of a real recording against what is known of it. docs/real.md defines every score."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.real.facts import Disturbance, Fact, Name
from benchmarks.real.said import Said, told
from imubench.arrays import Array
from imubench.diagnosis.result import Finding, Pair, Where
from imubench.score import axis_deviation, line_deviation

CONFIDENT = 0.9
HELDOUT = 1.2  # held-out misfit up to which a model can be called the whole explanation; 1 is noise
ANGLE_WORSE = np.deg2rad(0.06)  # rad RMS: a reference's clock known to 0.5 ms, a hinge at 2 rad/s RMS
AXIS_WORSE = np.deg2rad(
    0.3
)  # rad: as far as matching slow rates is off with 2 ms or 0.6 deg/s (tests/test_real_axes.py)
ANGLE = "hinge_angle_but_constant"


@dataclass(frozen=True)
class AxisError:
    """How far the axes of one estimator are off."""

    off: Array | None  # rad (2,), at imu1 and imu2; None where there is no answer
    status: str  # as the estimator has it, or why there is no answer

    @property
    def converged(self) -> bool:
        return self.status == "converged"


@dataclass(frozen=True)
class CaseScore:
    """What one diagnosis was worth. None: the question does not arise in this case."""

    verdict: str
    named: bool | None = None  # everything that is there has a finding of its own, by name and place
    located: bool | None = None  # everything that is there has one by name, or without a name at its place and band
    silent: bool | None = None  # nothing that matters is there, and nothing is said to be
    besides: tuple[str, ...] = ()  # sure and material findings that are none of what is known
    wrong: tuple[str, ...] = ()  # why a verdict `explained` is wrong
    heldout: Pair | None = None  # misfit on held-out data, as declared and with the findings
    angle: Pair | None = None  # rad RMS, hinge angle against the optical record but for a constant; the same two
    axes: Mapping[str, tuple[AxisError, AxisError]] = field(default_factory=dict)  # by estimator, raw and --with
    stopped: bool = False  # by its time limit

    @property
    def angle_worse(self) -> bool | None:
        """Whether the hinge angle is worse with what was found than as declared."""
        return None if self.angle is None else self.angle[1] > self.angle[0] + ANGLE_WORSE


def scored(
    said: Said,
    fact: Fact,
    raw: Mapping[str, Any] | None = None,
    corrected: Mapping[str, Any] | None = None,
    axes: Array | None = None,
) -> CaseScore:
    """Return the score of a diagnosis.

    Args:
        said: the diagnosis.
        fact: what is known of the recording.
        raw: what estimators say of the recording, by name: `value` (2, 3), `pairing`, `status`.
        corrected: the same with the findings taken out.
        axes: the hinge axes (2, 3) in the axes of the IMUs.
    """
    d = said.diagnosis
    pairs = matched(fact.there, said.sure)
    located = [name in pairs or any(_located(f, name, d.where) for f in said.sure) for name in fact.there]
    own = [*pairs.values(), *(f for f in said.sure for t in fact.there if t not in pairs and _located(f, t, d.where))]
    besides = [f for f in said.alarms if not any(f is one for one in own)]
    reference = d.fit.reference
    angle = (reference.before[ANGLE], reference.after[ANGLE]) if ANGLE in reference.before else None
    off = deviations(raw or {}, corrected or {}, axes)
    return CaseScore(
        d.verdict,
        len(pairs) == len(fact.there) if fact.there else None,
        all(located) if fact.there else None,
        not besides if fact.complete and not fact.there else None,
        tuple(told(f) for f in besides),
        tuple(wrong(said, fact, pairs, angle, off)) if d.verdict == "explained" else (),
        d.fit.heldout,
        angle,
        off,
        bool(d.stopped),
    )


def wrong(
    said: Said,
    fact: Fact,
    pairs: Mapping[Disturbance, Finding],
    angle: Pair | None,
    axes: Mapping[str, tuple[AxisError, AxisError]],
) -> list[str]:
    """Return in words what contradicts a diagnosis that says that everything is explained."""
    heldout = said.diagnosis.fit.heldout[1]
    out = [f"{there.what} not named" for there in fact.there if there not in pairs]
    if heldout > HELDOUT:
        out.append(f"held out {heldout:.2f}")
    if angle is not None and angle[1] > angle[0] + ANGLE_WORSE:
        out.append(f"hinge angle {np.degrees(angle[0]):.2f} to {np.degrees(angle[1]):.2f} deg")
    for name, (before, after) in ((name, (b.off, a.off)) for name, (b, a) in axes.items()):
        if before is not None and after is not None and bool(np.any(after > before + AXIS_WORSE)):
            out.append(f"axis by {name} {degrees(before)} to {degrees(after)} deg")
    if fact.complete:
        right = [*fact.may, *(name for there in fact.there for name in there.names)]
        confident = [f for f in said.alarms if f.named and f.confidence >= CONFIDENT]
        out += [f"{f.effect} at {f.at} is not there" for f in confident if not names(f, right)]
    return out


def matched(there: Sequence[Disturbance], findings: Sequence[Finding]) -> dict[Disturbance, Finding]:
    """Return the finding that names each disturbance, itself or by an equivalent; one finding names one alone."""
    out: dict[Disturbance, Finding] = {}
    for direct in (True, False):
        for one in (t for t in there if t not in out):
            free = [f for f in findings if f.named and not any(f is taken for taken in out.values())]
            found = next((f for f in free if names(f, one.names, direct)), None)
            if found is not None:
                out[one] = found
    return out


def names(finding: Finding, right: Sequence[Name], direct: bool = False) -> bool:
    """Return whether a finding, or unless `direct` one of its equivalents, is among some names."""
    return any(name in right for name in answers(finding)[: 1 if direct else None])


def answers(finding: Finding) -> list[Name]:
    """Return what a finding says: its own name and place, then those of its equivalents."""
    return [(finding.effect, finding.at), *((e.effect, e.at) for e in finding.equivalent)]


def _located(finding: Finding, there: Disturbance, where: Sequence[Where]) -> bool:
    """Return whether a finding without a name is at a disturbance's place, in a band that begins where it does."""
    if finding.named or finding.at != there.at:
        return False
    spots = [finding.where] if finding.where is not None else [w for w in where if w.at == finding.at]
    return there.above_hz == 0 or any(low >= there.above_hz for spot in spots for low, _ in spot.bands_hz)


def deviations(
    raw: Mapping[str, Any], corrected: Mapping[str, Any], axes: Array | None
) -> dict[str, tuple[AxisError, AxisError]]:
    """Return for each estimator how far its axes are off, without and with the findings taken out."""
    if axes is None:
        return {}
    missing = {"status": corrected.get("refused", "not asked")}
    return {name: (_off(raw[name], axes), _off(corrected.get(name, missing), axes)) for name in raw}


def _off(said: Mapping[str, Any], axes: Array) -> AxisError:
    if "value" not in said:
        return AxisError(None, said["status"])
    deviation = line_deviation if said["pairing"] == "unknown" else axis_deviation
    return AxisError(np.asarray(deviation(said["value"], axes)), said["status"])


def degrees(off: Array) -> str:
    """Return deviations at imu1 and imu2, rad, in deg."""
    return " / ".join(f"{x:.1f}" for x in np.degrees(off))
