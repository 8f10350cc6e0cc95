"""What is said in the end: findings of the fit and of the raw samples together, and what no recording could show."""

from collections.abc import Collection

import numpy as np

from imubench.diagnosis.config.shared import CONFIDENCE, EVIDENCE
from imubench.diagnosis.config.solve import SWING
from imubench.diagnosis.config.verdict import FINDINGS
from imubench.diagnosis.discrepancy.terms import LATE
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import CHANNELS
from imubench.diagnosis.problem.rig_kinematics import Rig
from imubench.diagnosis.result import Finding, Unseen, Verdict
from imubench.diagnosis.samples.screening import SampleChecks
from imubench.diagnosis.search.confidence import DOUBTFUL, STRANGE, at_most
from imubench.effects import EFFECTS, traits_of
from imubench.effects.traits import Fault
from imubench.recording import Recording


def with_samples(
    fitted: tuple[Finding, ...], samples: SampleChecks, rest: tuple[Finding, ...] = ()
) -> tuple[Finding, ...]:
    """Return what the fit found, and what the raw samples show that it did not find itself.

    A hum is doubted beside a torque without a name, which may hum: cogs at the rate that they pass; and at an IMU that
    has something without one, for a mount that is on no straight springs rings too.
    """
    same = {(f.effect, f.at) for f in fitted}
    knocking = any(traits_of(f.effect).knocks for f in fitted)
    raw = samples.findings if knocking else (*samples.findings, *samples.unless_stopped)
    if knocking:
        raw = tuple(f for f in raw if traits_of(f.effect).fault is not Fault.STRUCK)
    strange = {u.at for u in rest}
    raw = tuple(at_most(f, DOUBTFUL) if traits_of(f.effect).tone and strange & {f.at, "joint"} else f for f in raw)
    return (*fitted, *(f for f in raw if (f.effect, f.at) not in same))


def doubted_beside_unknown(
    named: tuple[Finding, ...],
    rest: tuple[Finding, ...],
    doubted: Collection[Hypothesis] = (),
    certain: Collection[str] = (),
) -> tuple[Finding, ...]:
    """Return named findings, doubted where something without a name explains as much.

    So do `doubted`, and those at whose place something without a name is worth much: it may be all. A state without a
    law explains what is anywhere, and what is worth more than a name may be at the other IMU and seem to be at this;
    what is worth much of it may be a part of that (another inertia beside cross-talk). What gains less than nothing on
    held-out data was found by what it spares the motion: how much of a name it would take is not known. Springs beside
    a joint's spline that is worth more may ring of what it rounds off (play jumps) and a mount be turned by what it
    cannot hold. A sensor that turns as the joint does reads what such a spline follows too: the angle that it scales
    tells the two apart in second order alone. A misalignment beside what its axes read a little later may be that too,
    as cross-talk is. Effects that are there whatever else is (`certain`) are not doubted.
    """
    equalled = {(h.effect.name, h.at) for h in doubted}
    loose = max((f.heldout_gain.value for f in named if f.at == "joint" and _free(f)), default=0.0)

    def sure(f: Finding) -> float:
        if f.effect in certain:
            return 1.0
        worth = [(u.heldout_gain.value, FINDINGS.much if _free(f) or u.at == f.at else 1.0) for u in rest]
        if any(gain > share * f.heldout_gain.value for gain, share in worth):
            return STRANGE
        traits, outweighed = traits_of(f.effect), loose > f.heldout_gain.value
        if traits.scales_angle and outweighed:
            return STRANGE
        held = traits.on_springs or traits.misplaces or bool(traits.onset)
        spared = any(u.at == f.at and u.heldout_gain.value < 0 for u in rest)
        part = any(gain > FINDINGS.much * f.heldout_gain.value for gain, _ in worth) or (held and outweighed)
        return DOUBTFUL if part or spared or _late(f, rest) or (f.effect, f.at) in equalled else 1.0

    return tuple(at_most(f, sure(f)) for f in named)


def _late(f: Finding, rest: tuple[Finding, ...]) -> bool:
    """Return whether something without a name is what the axes of a misalignment read, a little later."""
    traits = traits_of(f.effect)
    if not traits.crosses_axes:
        return False
    channels = CHANNELS[traits.channel]
    places = [u.where for u in rest if u.at == f.at and u.where is not None]
    return any(w.depends_on.endswith(LATE) and any(c in channels for c in w.channels) for w in places)


def _free(f: Finding) -> bool:
    effect = EFFECTS.get(f.effect)
    return effect is not None and effect.free


def ranked_by_confidence(named: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """Return findings in their order, those that are doubted behind those that are sure.

    What stands in for something without a name, or for another name, gains whatever that would: the gain alone does not
    rank them.
    """
    return tuple(sorted(named, key=lambda f: f.confidence < CONFIDENCE.sure))


def verdict_of(
    named: tuple[Finding, ...], rest: tuple[Finding, ...], noise_unknown: Collection[str] = (), doubted: bool = False
) -> Verdict:
    """Return the verdict that goes with findings by name, of which some may be all but refuted, and without one.

    Beside sensors whose noise nobody knows (`noise_unknown`) what is left cannot be said to be noise alone. A model
    that is `doubted` explains nothing to the end.
    """
    if any(f.confidence >= CONFIDENCE.counts for f in named):
        return "partly explained" if rest or noise_unknown or doubted else "explained"
    return "unexplained" if rest else "no mismatch"


def noise_not_shown(noise_unknown: Collection[str]) -> Unseen:
    """Return that a recording cannot show whether what is left of some triples is their noise."""
    sensors = ", ".join(noise_unknown)
    return Unseen(
        f"whether what is left is only noise: nobody declares that of {sensors}, and no rest shows it",
        "the same with the sensors lying still for 3 s, or with their noise declared",
    )


def not_observable(recording: Recording) -> tuple[Unseen, ...]:
    """Return what the recording is too poor in sensors, too still or too short to show."""
    out = []
    rig = Rig.of(recording)
    unknown = 3 * rig.turns + 3 * rig.moves + rig.hinge
    poses = sum(3 * (p.position is not None) + 3 * (p.quaternion is not None) for p in recording.poses)
    channels = 6 * len(recording.imus) + len(recording.encoders) + poses
    if channels <= unknown and not recording.free_swings:
        out.append(
            Unseen(
                f"any mismatch: {channels} channels leave nothing to check once {unknown} motions are found from them",
                "the same with a second IMU, an encoder or a measured pose, or a declared free swing",
            )
        )
    stamps = [i.time for i in recording.imus] + [e.time for e in recording.encoders] + [p.time for p in recording.poses]
    seconds = max(t[-1] for t in stamps) - min(t[0] for t in stamps)
    if seconds < EVIDENCE.least_s:
        out.append(Unseen(f"anything that takes longer than {seconds:.1f} s to show", "20 s or more of motion"))
    if recording.imus and all(np.sqrt(np.mean(np.sum(i.gyro**2, axis=1))) < SWING.still_rad_s for i in recording.imus):
        out.append(Unseen("mounts, scales and everything that shows with motion", "turns about every axis, 2 rad/s"))
    return tuple(out)


__all__ = [
    "doubted_beside_unknown",
    "noise_not_shown",
    "not_observable",
    "verdict_of",
    "with_samples",
]
