"""Which motion would tell two effects apart that a recording cannot: expected before anyone has moved.

Information needs no measurement, only a model at a motion. So each motion of the menu is laid on the recording's
own model, rates and noise, and the loss of `equivalents` is taken there: the log Bayes factor that a recording of that
motion is expected to have for the effect, at its fitted size, over its rival.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.config.simulation import EXPERIMENT
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.criteria.signatures import MARK, JointInformation, joint_information, signature
from imubench.diagnosis.experiments.motion_menu import MENU, Motion, Stage, Swing
from imubench.diagnosis.experiments.planned_recording import (
    assumed_forearm,
    measured_model,
    readings,
    state_of_stage,
    unmeasured_recording,
)
from imubench.diagnosis.experiments.symmetries import same_readings
from imubench.diagnosis.problem.dynamics_factors import inertia_about_joint
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.residuals import SWING_EQUATION
from imubench.diagnosis.problem.rig_kinematics import ATTITUDE, HINGE_AXIS
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.initialize import model_of
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.effects.effect import Scene
from imubench.jets import Jet
from imubench.links import ZERO
from imubench.links import Motion as Moved
from imubench.recording import Recording


@dataclass(frozen=True)
class Separation:
    """A motion and what it is expected to show."""

    motion: Motion
    seconds: float
    gain: float  # nat

    weighed: bool = True  # the recording declares the body that swings

    @property
    def sentence(self) -> str:
        """As it stands in diagnosis.json."""
        free = any(s.free for s in self.motion.stages)
        also = "" if self.weighed or not free else ", mass and inertia declared"
        return f"{self.seconds:g} s of {self.motion.words}{also}: expected log Bayes factor {self.gain:.0f}"


def separate(
    fit: Fit, pairs: Sequence[tuple[Hypothesis, Hypothesis]], seconds: float = EXPERIMENT.recording_s
) -> list[Separation | None]:
    """Return for each kept effect and its rival the motion that tells them best, None where none of the menu does."""
    recording = fit.model.recording
    told = [not same_readings(*pair, recording, swings=True) for pair in pairs]
    asked = [pair for pair, can in zip(pairs, told, strict=True) if can]
    table = {motion: expected(fit, asked, motion, seconds) for motion in playable(recording)} if asked else {}
    found = iter(
        [_best(fit, pair, {m: gains[i] for m, gains in table.items()}, seconds) for i, pair in enumerate(asked)]
    )
    return [next(found) if can else None for can in told]


def _best(
    fit: Fit, pair: tuple[Hypothesis, Hypothesis], gains: dict[Motion, float], seconds: float
) -> Separation | None:
    """Return the motion that tells an effect from a rival best, by what is expected; None where it would not."""
    recording = fit.model.recording
    some = {
        m: gain
        for m, gain in gains.items()
        if not same_readings(*pair, recording, swings=any(stage.free for stage in m.stages))
    }
    most = max(some.values(), default=0.0)
    if most <= EVIDENCE.clear_nat:
        return None
    motion = next(m for m, gain in some.items() if gain >= EXPERIMENT.nearly * most)
    gain = some[motion] if recording.poses else min(some[motion], at_size(fit, *pair, motion, seconds))
    return Separation(motion, seconds, gain, recording.body is not None) if gain > EVIDENCE.clear_nat else None


def separation(fit: Fit, h: Hypothesis, rivals: Sequence[Hypothesis]) -> str:
    """Return the sentence about the motion that tells a kept effect from all its rivals, or what comes nearest.

    Not from what has states, nor from a hum elsewhere: rivals are taken at their start, and a hum's has another
    frequency, which any motion tells.
    """
    fitted = [r for r in rivals if not r.effect.states and not r.effect.tone]
    if h.effect.states or not fitted:
        return ""
    found = [s for s in separate(fit, [(h, r) for r in fitted]) if s is not None]
    return min(found, key=lambda s: s.gain).sentence if found else ""


def playable(recording: Recording) -> list[Motion]:
    """Return the motions of the menu that a recording's rig can do."""
    out = []
    for motion in MENU:
        swings = any(s.free for s in motion.stages)
        if swings and recording.tree.loose:
            continue
        if any(s.swapped for s in motion.stages) and len(recording.imus) < 2:
            continue
        out.append(motion)
    return out


def expected(
    fit: Fit, pairs: Sequence[tuple[Hypothesis, Hypothesis]], motion: Motion, seconds: float = EXPERIMENT.recording_s
) -> list[float]:
    """Return the log Bayes factor in nat that a motion is expected to show for each effect over its rival."""
    stages = [shown(fit, pairs, s, seconds / len(motion.stages)) for s in motion.stages]
    total = sum(s.information for s in stages)
    both = replace(stages[0], information=np.asarray(total))
    return [both.explained(both.along(f"{MARK} {h.name}")[:, 0], both.along(r.name))[0] for h, r in pairs]


def shown(fit: Fit, pairs: Sequence[tuple[Hypothesis, Hypothesis]], stage: Stage, seconds: float) -> JointInformation:
    """Return the information of every rival and of every effect's mark in one way to move."""
    kept, rivals = ({x.name: x for x in some} for some in zip(*pairs, strict=True))
    recording = unmeasured_recording(fit.model.recording, stage, seconds)
    model = replace(model_of(recording, 1 / fit.model.tracks.knots.step), mounts=fit.model.mounts)
    noise = {SWING_EQUATION: 1.0} | (_crossed(fit) if stage.swapped else fit.noise)
    swing = _swing(fit, recording, next(iter(kept.values()))) if stage.free else None
    still = state_of_stage(model, stage, swing)
    model = measured_model(model, still)
    bare = replace(fit, model=model, state=still, noise=noise)
    marks = {}
    for name, h in kept.items():
        there, values = placed(fit, h, stage, recording)
        has = extended(bare, (there,), values)
        marks[f"{MARK} {name}"] = signature(has, has.state, [there])[2]
    others = [_carried(r, stage, recording) for r in rivals.values()]
    begun = extended(bare, tuple(others))
    out = joint_information(begun.model, begun.state, begun, others, marks)
    factor = np.ones(len(out.prior))
    for r in others:
        if r.effect.acts("lighter"):
            factor[out.places[r.name]] = _lighter(fit.model.recording, recording)
    places = {name: out.places[_carried(r, stage, recording).name] for name, r in rivals.items()}
    places |= {name: out.places[name] for name in marks}
    return replace(out, places=places, information=out.information * np.outer(factor, factor))


def placed(fit: Fit, h: Hypothesis, stage: Stage, recording: Recording) -> tuple[Hypothesis, dict[str, Array]]:
    """Return an effect as it is in a stage, a recording of which is given, and its fitted numbers (k,) there."""
    there = _carried(h, stage, recording)
    values = {there.key(p.name): fit.state.values[h.key(p.name)] for p in h.effect.parameters}
    if h.effect.acts("lighter"):
        values = {key: 1 + (v - 1) * _lighter(fit.model.recording, recording) for key, v in values.items()}
    return there, values


def at_size(
    fit: Fit, h: Hypothesis, rival: Hypothesis, motion: Motion, seconds: float = EXPERIMENT.recording_s
) -> float:
    """Return by how many nat a rival fits worse than an effect that is there, by simulating it and fitting both.

    The linear prediction holds for a small effect and a motion that the splines follow exactly. Here the motion is laid
    on knots twice as close, the effect acts at its fitted size, the readings have no noise, and both models are fitted
    to them on the knots that the recording has: what the splines cannot follow is then in both costs.

    Args:
        fit: that has the effect.
        h: the effect.
        rival: what could stand for it.
        motion: of the menu. Each of its stages is fitted by itself, so that a rival that must be one number in all
            is given more freedom: the sum is a lower bound.
        seconds: of the motion.
    """
    total = 0.0
    for stage in motion.stages:
        recording = unmeasured_recording(fit.model.recording, stage, seconds / len(motion.stages))
        swing = _swing(fit, recording, h, pulled=True) if stage.free else None
        there, values = placed(fit, h, stage, recording)
        noise = {SWING_EQUATION: 1.0} | (_crossed(fit) if stage.swapped else fit.noise)
        fine, coarse = (
            replace(model_of(recording, k / fit.model.tracks.knots.step), mounts=fit.model.mounts) for k in (2, 1)
        )
        truth = extended(
            replace(fit, model=fine, state=state_of_stage(fine, stage, swing), noise=noise), (there,), values
        )
        model = replace(coarse, recording=readings(truth.model, truth.state))
        bare = replace(fit, model=model, state=state_of_stage(model, stage, swing), noise=noise)
        costs = []
        for one, guess in ((there, values), (_carried(rival, stage, recording), None)):
            begun = extended(bare, (one,), guess)
            turns = model.tracks.columns(ATTITUDE) if model.rig.turns else None
            first = None if turns is None else begun.state.coefficients[0, turns]
            costs.append(solve(begun.model, begun.state, begun.noise, first, steps=SOLVER.refit_steps).cost)
        total += costs[1] - costs[0]
    return total


def _swing(fit: Fit, recording: Recording, h: Hypothesis, pulled: bool = False) -> Swing:
    """Return how a recording's body swings with an effect that may resist it; `pulled`: or be what pulls at it."""
    assert recording.body is not None  # `playable` leaves free swings out without one
    values = fit.model.values(h, fit.state) if h in fit.model.hypotheses else {}
    axis = Jet(np.eye(3)[[HINGE_AXIS]])
    still = Moved(ZERO, ZERO, ZERO)

    def torque(angle: float, rate: float) -> float:
        turning = Jet(np.array([[rate]]))
        scene = Scene(
            Jet(np.zeros((1, 1))),
            still,
            Jet(np.array([[angle]])),
            turning,
            Jet(np.zeros((1, 1))),
            turning.at(np.eye(3)[:, [HINGE_AXIS]]),
            axis,
        )
        out = h.effect.torque(scene, {n: Jet(v.value) for n, v in values.items()}) if values else None
        return 0.0 if out is None else float(out.value[0, HINGE_AXIS])

    gravity = recording.gravity or 9.81
    if pulled and values:
        numbers = {n: Jet(v.value) for n, v in values.items()}
        gravity = float(np.linalg.norm(h.effect.gravity(Jet(np.array([[0.0, 0.0, -gravity]])), numbers).value))
        factor = h.effect.lighter(numbers)  # m l / I is so many times what is declared, and m g l / I with it
        gravity *= 1.0 if factor is None else float(factor.value.ravel()[0])
    return Swing(recording.body, fit.model.rig.base, gravity, torque)


def _exchanged(recording: Recording) -> dict[str, str]:
    """Return for both IMUs beside the joint the one in whose place it is where they are swapped."""
    pair = recording.tree.pair or ()
    return dict(zip(pair, reversed(pair), strict=True))


def _carried(h: Hypothesis, stage: Stage, recording: Recording) -> Hypothesis:
    """Return where an effect sits in a stage: what a sensor bears goes with it."""
    if stage.swapped and h.effect.borne:
        return replace(h, at=_exchanged(recording).get(h.at, h.at))
    return h


def _crossed(fit: Fit) -> dict[str, float]:
    """Return a fit's noise levels with the sensors in each other's place."""
    other = _exchanged(fit.model.recording)
    groups = ((*name.partition("."), std) for name, std in fit.noise.items())
    return {other.get(at, at) + dot + part: std for at, dot, part, std in groups}


def _lighter(before: Recording, after: Recording) -> float:
    """Return by what a relative error of the inertia shrinks with the mass that was added."""
    one, two = (inertia_about_joint(r.body or assumed_forearm(r))[HINGE_AXIS, HINGE_AXIS] for r in (before, after))
    return float(one / two)
