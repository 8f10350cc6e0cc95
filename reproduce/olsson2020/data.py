"""The samples that all experiments work on, made once in every process."""

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from imubench.estimators.hinge_constraints import Constraints, weigh
from imubench.estimators.olsson2020 import W_ACCEL, W_GYRO
from imubench.estimators.plug_and_play import batches
from imubench.estimators.selection import Selected
from imubench.estimators.selection_online import OnlineSelection
from imubench.paired import Paired, paired
from imubench.recording import Recording
from imubench.reproduce.olsson2020.settings import DURATIONS, MOTIONS, Settings
from imubench.reproduce.paper import Trial
from imubench.scenarios.olsson2020.named import truth_of
from imubench.scenarios.olsson2020.plan import SEQUENCES, Piece, Plan
from imubench.scenarios.olsson2020.sequences import Sequence, join
from imubench.scenarios.olsson2020.session import Session, record
from imubench.truth import Truth


@lru_cache(maxsize=4)
def session(seed: int) -> Session:
    """Return the recording of all 14 motions from which everything is cut."""
    return record(seed, durations=DURATIONS)


@lru_cache(maxsize=8)
def sequence(name: str, seed: int) -> Sequence:
    """Return one of the paper's four sequences."""
    return join(SEQUENCES[name], session(seed))


def whole_seconds(of: Sequence) -> range:
    """Return the batches of a second that a sequence has, the last one perhaps shorter."""
    return range(math.ceil(of.duration - 1e-6))


def motion(number: int, seed: int) -> Paired:
    """Return the samples of one motion."""
    whole, (start, end) = session(seed), session(seed).span(number)
    return rows(paired(whole.recording), start, end)


def whole(name: str, seed: int) -> tuple[Recording, Truth]:
    """Return the recording of a motion (`motion 11`) or of a sequence (`sequence1`), and what really happened."""
    kind, _, number = name.partition(" ")
    plan = SEQUENCES[name] if not number else Plan(f"{kind}{number}", (Piece(int(number)),))
    found = join(plan, session(seed))
    return found.recording, truth_of(found, session(seed))


def trials(s: Settings) -> list[Trial]:
    """Return the motions in which the joint turns and the sequences, for any estimator."""
    names = [*(f"motion {number}" for number in MOTIONS), *SEQUENCES]
    return [Trial(name, whole, {"name": name, "seed": s.seed}) for name in names]


def rows(samples: Paired, start: float, end: float) -> Paired:
    """Return the samples of [start, end) s."""
    first, last = np.searchsorted(samples.time, [start - 1e-6, end - 1e-6])
    cut = slice(int(first), int(last))
    return Paired(samples.time[cut], samples.gyro1[cut], samples.accel1[cut], samples.gyro2[cut], samples.accel2[cut])


@lru_cache(maxsize=3)
def selections(name: str, seed: int, n_max: int) -> list[Selected]:
    """Return the samples that Algorithms 2 and 3 hold after each second of a sequence."""
    return list(select_all(sequence(name, seed).recording, n_max))


def select_all(recording: Recording, n_max: int) -> Iterator[Selected]:
    """Yield what Algorithms 2 and 3 hold after each second of any recording."""
    stream = OnlineSelection(n_max)
    for b in batches(paired(recording)):
        yield stream.update(b.gyro1, b.gyro2, b.accel1, b.accel2)


def weighed(chosen: Selected) -> Constraints:
    """Weigh selected samples with the paper's w0 = 50."""
    return weigh(chosen.gyro1, chosen.gyro2, chosen.accel1, chosen.accel2, W_GYRO, W_ACCEL)


def weighed_until(samples: Paired, count: int) -> Constraints:
    """Weigh the first `count` samples."""
    cut = slice(0, count)
    return weigh(samples.gyro1[cut], samples.gyro2[cut], samples.accel1[cut], samples.accel2[cut], W_GYRO, W_ACCEL)


def motions_of(name: str, seed: int) -> NDArray[np.int_]:
    """Return the motion (n,) that each sample of a sequence comes from."""
    whole = sequence(name, seed)
    time = paired(whole.recording).time
    starts = np.array([section.start for section in whole.sections])
    places = np.searchsorted(starts, time + 1e-6, side="right") - 1
    return np.array([section.motion for section in whole.sections])[places]
