"""What rounding may be taken for: its error is regular where noise does not blur the steps.

A reading that stays on a step while the sensor turns slowly is off by what goes with the motion, which is no white
noise: springs may seem to explain it. Noise of standard deviation s blurs steps of d, and leaves exp(-2 (pi s / d)^2)
of what is regular in their error. Where that is most of it, effects with states that are found there may be rounding
alone.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.result import Finding
from imubench.diagnosis.search.confidence import DOUBTFUL, STRANGE, at_most
from imubench.diagnosis.search.moves.move import Proposal, Proposals, SearchState
from imubench.diagnosis.solve.refit import refit_without
from imubench.effects import EFFECTS, traits_of
from imubench.effects.traits import Fault
from imubench.recording import Recording

SHARP = 0.5  # of what is regular in rounding, left by the noise: more, and noise does not blur the steps
ROUNDED = 0.5  # nat for each rounded number, that a state may gain of rounding, which changes as slowly as it does


@dataclass(frozen=True)
class Rounding:
    """What the rounding of a sensor may be, at its IMU or at the joint beside a lone one."""

    nat: float  # that a state may gain of it
    regular: float  # of its error, what noise leaves regular
    hum: float  # m/s^2, the most that it has at one frequency: step / pi


def roundings(findings: Iterable[Finding], recording: Recording) -> dict[str, Rounding]:
    """Return the rounding among some findings, by the places at which it may be taken for something else."""
    out = {}
    for rounded in (f for f in findings if traits_of(f.effect).fault is Fault.ROUNDED):
        imu, step = recording.imu(rounded.at), rounded.parameters["step"]
        turns = step.unit == "rad/s"
        x, std = (imu.gyro, imu.gyro_noise_std) if turns else (imu.accel, imu.accel_noise_std)
        regular = float(np.exp(-2 * (np.pi * (std or 0.0) / float(step.value)) ** 2))
        hum = 0.0 if turns else float(step.value) / np.pi
        for at in (imu.name, "joint") if len(recording.imus) == 1 else (imu.name,):
            out[at] = Rounding(ROUNDED * x.size, regular, hum if at == imu.name else 0.0)
    return out


def sharp(findings: Iterable[Finding], recording: Recording) -> dict[str, float]:
    """Return the nat that a state may gain of rounding that noise does not blur, by place."""
    return {at: r.nat for at, r in roundings(findings, recording).items() if r.regular > SHARP}


class RoundedStates:
    """The fit without states that gain no more than rounding has, by place.

    They would follow the steps with numbers that no mount has, and cast doubt on the effects beside them.
    """

    def propose(self, state: SearchState) -> Proposals:
        """Yield the fit without all of them."""
        gains = state.rounding
        rounded = [k for k in state.kept if k.hypothesis.effect.states and k.hypothesis.at in gains]
        gone = [k for k in rounded if k.heldout.value < gains[k.hypothesis.at]]
        if gone:
            names = [k.hypothesis for k in gone]
            yield Proposal(
                f"without {' and '.join(h.name for h in names)}, which rounding may be",
                lambda _: state.without(
                    tuple((k.hypothesis, k.heldout.value) for k in gone), with_noise(refit_without(state.fit, names))
                ),
            )


def beside_rounding(
    named: tuple[Finding, ...], recording: Recording, heard: Collection[str] = ()
) -> tuple[Finding, ...]:
    """Return named findings, motions of an IMU or beside a lone one doubted where rounding may be all they explain.

    So are slips that are told by their moment alone, which lose on held-out data (a reading leaves a step there), and
    hums that no raw samples have (`heard`: the IMUs whose samples hum), up to the largest amplitude that a regular
    error of rounding has at one frequency.
    """
    rounded = roundings(named, recording)

    def sure(f: Finding) -> float:
        effect = EFFECTS.get(f.effect)
        if f.at not in rounded or effect is None:
            return 1.0
        rounding = rounded[f.at]
        lasting = bool(effect.states) and f.heldout_gain.value < rounding.nat
        size = float(np.linalg.norm(f.parameters["amplitude"].value)) if effect.tone else np.inf
        stepped = bool(effect.onset) and f.heldout_gain.value <= 0
        told = lasting or stepped or (f.at not in heard and size < rounding.hum)
        return (STRANGE if rounding.regular > SHARP else DOUBTFUL) if told else 1.0

    return tuple(at_most(f, sure(f)) for f in named)


__all__ = ["RoundedStates", "beside_rounding", "roundings", "sharp"]
