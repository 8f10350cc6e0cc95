"""The 14 motions and the sequences as scenarios, by name: `olsson2020/motion-11`, `olsson2020/sequence-1`.

A motion is played on the paper's rig and recorded by itself, its first and last second left out. A sequence is cut from
a session, all motions recorded one after the other (docs/olsson2020-motions.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from imubench.errors import InputError
from imubench.recording import Recording
from imubench.scenarios.olsson2020 import sequences
from imubench.scenarios.olsson2020.motions import DURATION, MARGIN, MOTIONS, OlssonMotion, paper_rig
from imubench.scenarios.olsson2020.plan import SEQUENCES, Plan
from imubench.scenarios.olsson2020.session import Session, record
from imubench.scenarios.scenario import Experiment, Play, Scenario, prescribed
from imubench.sim.imu_profile import ImuProfile
from imubench.sim.injected import Injected
from imubench.sim.motion import Later
from imubench.truth import Truth

PAPER = "olsson2020"


@dataclass(frozen=True)
class SequenceScenario:
    """A sequence of the paper; the motions, and so the pieces, are as long as they are."""

    name: str
    plan: Plan
    estimator: str | None = "olsson2020"
    profile: str = "xsens_mtw"
    rig: str = "hinge"
    seconds: float = 0.0  # s
    swings: bool = False

    @property
    def summary(self) -> str:
        """What it is, in a line."""
        return f"{self.plan.summary}, {self.seconds:g} s"

    def record(
        self, seed: int, imu: ImuProfile | None = None, seconds: float | None = None, effects: Sequence[Injected] = ()
    ) -> tuple[Recording, Truth]:
        """Return the recording and what really happened, as `Scenario.record` does.

        Raises:
            InputError: for another duration, or effects: a sequence is cut from a session of fourteen motions, in
                which nothing says when an effect begins.
        """
        for what, given in (("duration", seconds is not None and seconds != self.seconds), ("effects", bool(effects))):
            if given:
                raise InputError(f"{self.name}: expected no {what} beside its own; its motions alone take one")
        session = record(seed, imus=imu)
        sequence = sequences.join(self.plan, session)
        name = f"{self.name.replace('/', '-')}-{seed}"
        return replace(sequence.recording, name=name), truth_of(sequence, session)


def truth_of(sequence: sequences.Sequence, session: Session) -> Truth:
    """Return what really happened in a sequence: the pieces of its session's truth on one clock."""
    truth = session.truth
    rate = 1.0 / (truth.time[1] - truth.time[0])
    rows = []
    for section in sequence.sections:
        first = round((session.span(section.motion)[0] + section.cut_start) * rate)
        rows.append(np.arange(first, first + round((section.end - section.start) * rate)))
    chosen = np.concatenate(rows)

    def cut(part: Any) -> Any:
        arrays = {f.name: getattr(part, f.name) for f in fields(part)}
        return replace(part, **{key: a[chosen] for key, a in arrays.items() if isinstance(a, np.ndarray)})

    return replace(
        cut(truth),
        time=np.arange(chosen.size) / rate,
        segments=tuple(cut(segment) for segment in truth.segments),
        sensors=tuple(cut(sensor) for sensor in truth.sensors),
        labels=tuple((f"motion {s.motion}: {MOTIONS[s.motion].name}", s.start, s.end) for s in sequence.sections),
    )


def _played(motion: OlssonMotion) -> Play:
    def play(rng: np.random.Generator, seconds: float, effects: Sequence[Injected]) -> Experiment:
        return prescribed(paper_rig(), Later(motion.motion(rng, seconds), MARGIN), seconds, rng, effects)

    return play


def _length(plan: Plan) -> float:
    cuts = [(piece.cut(DURATION, plan.name), piece.repeat) for piece in plan.pieces]
    return sum((end - start) * repeat for (start, end), repeat in cuts)


SCENARIOS: tuple[Scenario | SequenceScenario, ...] = (
    *(
        Scenario(
            f"{PAPER}/motion-{number}",
            f"motion {number} of Olsson et al. 2020: {motion.name}",
            "olsson2020",
            "xsens_mtw",
            _played(motion),
            seconds=DURATION,
        )
        for number, motion in MOTIONS.items()
    ),
    *(
        SequenceScenario(f"{PAPER}/{name.replace('sequence', 'sequence-')}", plan, seconds=_length(plan))
        for name, plan in SEQUENCES.items()
    ),
)
