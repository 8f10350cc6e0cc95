"""The motions of the segments at the last few times and states that were asked for.

Two IMUs of one rate ask for the same, and so do all states of an effect that are tried beside one motion.
"""

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable, Mapping
from threading import Lock

import numpy as np

from imubench.diagnosis.problem.bspline import KEPT_LONG_BASES, LONG_TIMES, Moment
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.jets import follows
from imubench.links import Motion

Motions = Mapping[str, Motion]


class KeptMotions:
    """The last few motions by what they follow from."""

    def __init__(self) -> None:
        self._kept: OrderedDict[Hashable, Motions] = OrderedDict()
        self._lock = Lock()

    def get(self, key: Hashable, make: Callable[[], Motions]) -> Motions:
        """Return what is kept under a key, or else what `make` returns, which is then kept."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        made = make()
        with self._lock:
            self._kept[key] = made
            while len(self._kept) > KEPT_LONG_BASES:
                self._kept.popitem(last=False)
        return made


KEPT = KeptMotions()


def key_of(
    rig: Hashable, widths: Iterable[str], state: State, moment: Moment, acting: tuple[Hypothesis, ...]
) -> Hashable | None:
    """Return what the motions of segments follow from; None where they are not to be kept.

    Args:
        rig: the segments, and which of them are asked for.
        widths: the splines of their motion.
        state: the splines and the numbers.
        moment: the splines at times (n,).
        acting: the effects at the joint and of the world.
    """
    time = moment.time
    if len(time.value) > LONG_TIMES:
        return None  # memory
    own = [h.key(s.name) for h in acting for s in h.effect.states]
    numbers = [h.key(p.name) for h in acting for p in h.effect.parameters]
    splines = [name for name in (*widths, *own) if name in moment.tracks.widths]
    clock = tuple((key, d.shape, d.tobytes()) for key, d in time.blocks.items())
    return (
        rig,
        moment.tracks.knots,
        time.value.tobytes(),
        clock,
        acting,
        tuple(follows(name) for name in (*splines, *numbers)),
        tuple(moment.coefficients[:, moment.tracks.columns(name)].tobytes() for name in splines),
        tuple(np.asarray(state.values[name], dtype=float).tobytes() for name in numbers),
    )
