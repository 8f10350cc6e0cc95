"""What MuJoCo plays: a rig with its torques and springs, its sensors' effects, and the motion that drives it."""

from dataclasses import dataclass

import numpy as np

from imubench import rotations
from imubench.arrays import Array
from imubench.correction.found_chain import chain_of
from imubench.correction.found_rig import rig_of
from imubench.correction.sensor_chain import Effects, plays
from imubench.diagnosis.discrepancy.terms import Unknown
from imubench.diagnosis.evidence import Played
from imubench.diagnosis.problem.encoder_calibration import ERROR
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.rig_kinematics import HINGE
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.result import Finding, Interval
from imubench.diagnosis.verdict.effect_parameters import parameters
from imubench.sim.rigs import Rig
from imubench.sim.swing import Start


@dataclass(frozen=True)
class SimModel:
    """A model to be played beside a recording."""

    rig: Rig
    effects: Effects
    start: float  # s, the stamp that counts as zero
    motion: Played | None = None  # what the hand drives; None: nothing but free swings is played
    encoder_error: Array | None = None  # (1 + 2 waves,) rad, see `encoder_calibration`


def named(fit: Fit) -> tuple[Hypothesis, ...]:
    """Return the effects of a fit that have a law: what has no name is not played."""
    return tuple(h for h in fit.model.hypotheses if not isinstance(h.effect, Unknown))


def finding_of(fit: Fit, h: Hypothesis) -> Finding:
    """Return an effect of a fit as a finding, with the fit's numbers."""
    std = {h.key(p.name): np.zeros(p.width) for p in h.effect.parameters}
    return Finding(h.effect.name, h.at, 1.0, parameters(h, fit, std), Interval(0.0, (0.0, 0.0)))


def playable(fit: Fit, h: Hypothesis) -> bool:
    """Return whether MuJoCo plays an effect of a fit."""
    return plays(h.effect.name, fit.model.recording.rig)


def sim_model(fit: Fit) -> SimModel:
    """Return the model that a fit says, with its numbers and its motion."""
    recording, motion = fit.model.recording, fit_summary.played(fit)
    found = [finding_of(fit, h) for h in named(fit)]
    return SimModel(
        rig_of(recording, fit_summary.mounts(fit), found, motion.fitted),
        chain_of(found, motion.fitted, recording),
        fit.model.start,
        motion,
        fit.state.values.get(ERROR),
    )


def state_at(fit: Fit, time: float) -> Start:
    """Return the state of a fit's rig at a time in s of the recording's clock; its base or pivot stands still."""
    moment = fit.model.moment(fit.state, np.array([time]), "")
    if fit.model.rig.hinge:
        angle, rate = (float(moment.track(HINGE, order).value[0, 0]) for order in (0, 1))
        return Start(angle=angle, angle_rate=rate)
    first = fit.model.rig.first(moment)
    assert first.turn is not None  # a limb on a ball joint has an attitude
    matrix = np.broadcast_to(first.turn.matrix, (1, 3, 3))[0]
    return Start(quaternion=rotations.from_matrix(matrix), rate=np.broadcast_to(first.rate.value, (1, 3))[0])


__all__ = ["SimModel", "finding_of", "named", "playable", "sim_model", "state_at"]
