"""Which motion would tell two effects apart that a recording cannot: expected before anyone has moved.

Information needs no measurement, only a model at a motion. So each motion of the menu is laid on the recording's
own model, rates and noise, and the loss of `alike` is taken there: the log Bayes factor that a recording of that
motion is expected to have for the effect, at its fitted size, over its rival.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench.diagnosis.fit import Fit
from imubench.diagnosis.hypothesis import Hypothesis
from imubench.diagnosis.kinematics import HINGE_AXIS
from imubench.diagnosis.marks import MARK, Joint, joint, mark
from imubench.diagnosis.menu import MENU, Motion, Stage, Swing
from imubench.diagnosis.refit import extended
from imubench.diagnosis.staged import assumed, laid, read, staged
from imubench.diagnosis.start import model_of
from imubench.diagnosis.swings import GROUP, inertia_about_joint
from imubench.diagnosis.trial import HUM
from imubench.effects.effect import Scene
from imubench.jets import Jet
from imubench.links import ZERO
from imubench.links import Motion as Moved
from imubench.recording import Recording

SECONDS = 20.0
CLEAR = 10.0  # nat: a motion that is expected to show less separates nothing
NEARLY = 0.9  # of the best: from there the motion that comes first in the menu, the simpler one, is named
BORNE = (
    "gyro_", "accel_", "g_sensitivity", "low_pass", "time_offset", "clock_skew", "saturation", "quantisation",
)  # fmt: skip
"""How effects begin that move with a sensor, not with its seat."""


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
    fit: Fit, pairs: Sequence[tuple[Hypothesis, Hypothesis]], seconds: float = SECONDS
) -> list[Separation | None]:
    """Return for each kept effect and its rival the motion that tells them best, None where none of the menu does."""
    table = {motion: expected(fit, pairs, motion, seconds) for motion in playable(fit.model.recording)}
    out = []
    for i in range(len(pairs)):
        most = max(gains[i] for gains in table.values())
        motion = next(m for m, gains in table.items() if gains[i] >= NEARLY * most)
        gain = table[motion][i]
        out.append(Separation(motion, seconds, gain, fit.model.recording.body is not None) if gain > CLEAR else None)
    return out


def separation(fit: Fit, h: Hypothesis, rivals: Sequence[Hypothesis]) -> str:
    """Return the sentence about the motion that tells a kept effect from all its rivals, or what comes nearest.

    Not from what has states, nor from a hum elsewhere: rivals are taken at their start, and a hum's has another
    frequency, which any motion tells.
    """
    fitted = [r for r in rivals if not r.effect.states and r.effect.name != HUM]
    if h.effect.states or not fitted:
        return ""
    found = [s for s in separate(fit, [(h, r) for r in fitted]) if s is not None]
    return min(found, key=lambda s: s.gain).sentence if found else ""


def playable(recording: Recording) -> list[Motion]:
    """Return the motions of the menu that a recording's rig can do."""
    out = []
    for motion in MENU:
        swings = any(s.free for s in motion.stages)
        if swings and recording.rig == "free":
            continue
        if any(s.swapped for s in motion.stages) and len(recording.imus) < 2:
            continue
        out.append(motion)
    return out


def expected(
    fit: Fit, pairs: Sequence[tuple[Hypothesis, Hypothesis]], motion: Motion, seconds: float = SECONDS
) -> list[float]:
    """Return the log Bayes factor in nat that a motion is expected to show for each effect over its rival."""
    stages = [shown(fit, pairs, s, seconds / len(motion.stages)) for s in motion.stages]
    total = sum(s.information for s in stages)
    both = replace(stages[0], information=np.asarray(total))
    return [both.explained(both.along(f"{MARK} {h.name}")[:, 0], both.along(r.name))[0] for h, r in pairs]


def shown(fit: Fit, pairs: Sequence[tuple[Hypothesis, Hypothesis]], stage: Stage, seconds: float) -> Joint:
    """Return the information of every rival and of every effect's mark in one way to move."""
    kept, rivals = ({x.name: x for x in some} for some in zip(*pairs, strict=True))
    recording = staged(fit.model.recording, stage, seconds)
    model = replace(model_of(recording, 1 / fit.model.tracks.knots.step), mounts=fit.model.mounts)
    noise = {GROUP: 1.0} | (_crossed(fit.noise) if stage.swapped else fit.noise)
    swing = _swing(fit, recording, next(iter(kept.values()))) if stage.free else None
    still = laid(model, stage, swing)
    model = read(model, still)
    bare = replace(fit, model=model, state=still, noise=noise)
    marks = {}
    for name, h in kept.items():
        there = _carried(h, stage)
        values = {there.key(p.name): fit.state.values[h.key(p.name)] for p in h.effect.parameters}
        if h.effect.name == "inertia":
            values = {key: 1 + (v - 1) * _lighter(fit.model.recording, recording) for key, v in values.items()}
        has = extended(bare, (there,), values)
        marks[f"{MARK} {name}"] = mark(has, has.state, [there])[2]
    others = [_carried(r, stage) for r in rivals.values()]
    begun = extended(bare, tuple(others))
    out = joint(begun.model, begun.state, begun, others, marks)
    factor = np.ones(len(out.prior))
    for r in others:
        if r.effect.name == "inertia":
            factor[out.places[r.name]] = _lighter(fit.model.recording, recording)
    places = {name: out.places[_carried(r, stage).name] for name, r in rivals.items()}
    places |= {name: out.places[name] for name in marks}
    return replace(out, places=places, information=out.information * np.outer(factor, factor))


def _swing(fit: Fit, recording: Recording, h: Hypothesis) -> Swing:
    """Return how a recording's body swings with an effect that may resist it."""
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

    return Swing(recording.body, fit.model.rig.base, recording.gravity or 9.81, torque)


def _carried(h: Hypothesis, stage: Stage) -> Hypothesis:
    """Return where an effect sits in a stage: what a sensor bears goes with it."""
    if stage.swapped and h.at in ("imu1", "imu2") and h.effect.name.startswith(BORNE):
        return replace(h, at="imu2" if h.at == "imu1" else "imu1")
    return h


def _crossed(noise: dict[str, float]) -> dict[str, float]:
    """Return the noise levels with the sensors in each other's place."""
    other = {"imu1.": "imu2.", "imu2.": "imu1."}
    return {other.get(name[:5], name[:5]) + name[5:]: std for name, std in noise.items()}


def _lighter(before: Recording, after: Recording) -> float:
    """Return by what a relative error of the inertia shrinks with the mass that was added."""
    one, two = (inertia_about_joint(r.body or assumed(r))[HINGE_AXIS, HINGE_AXIS] for r in (before, after))
    return float(one / two)
