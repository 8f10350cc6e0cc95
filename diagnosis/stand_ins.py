"""Names that may only stand in for something without one: which are held against terms, against which, how strictly."""

from collections.abc import Iterator, Sequence

import numpy as np

from imubench.diagnosis.alike import alike
from imubench.diagnosis.bases import drifts
from imubench.diagnosis.fit import Fit
from imubench.diagnosis.fitted_terms import NEEDED
from imubench.diagnosis.hypothesis import Hypothesis
from imubench.diagnosis.priors import inside, states_inside
from imubench.diagnosis.term_scores import Guess
from imubench.diagnosis.terms import FRICTION
from imubench.diagnosis.trial import FILTER

MUCH = 0.1  # of what names explain: a curve holds a scale too, and takes its place for no little of something else
CLOSE = 0.01  # of what a name explains: an unfitted promise says no less (what it goes with, 10 ms late, is nearly it)
TURNS = 0.2  # of what play explains that never comes back: a mount that turns slowly may explain so much less
QUICK = 0.1  # of its power: what a slow turn leaves of such play (of two creeping mounts 0.002 and 0.005, of play 0.6)
SLIP = "mount_shift"
MOVED = (SLIP, "mount_pose")
DRIFTS = ("gyro_drift", "accel_drift")
SLOW = (*DRIFTS, "gyro_bias", "accel_bias")


def groups(hypotheses: Sequence[Hypothesis]) -> list[tuple[Hypothesis, ...]]:
    """Return what a term may displace: splines without a law, filters, effects of one triple alone, and all of it.

    Laws of friction are displaced together: each alone is worth little beside another.
    """
    plain = [h for h in hypotheses if not h.effect.states]
    free = [h for h in hypotheses if h.effect.free or (h.effect.states and h.effect.name == FILTER)]
    triples: dict[tuple[str, str], list[Hypothesis]] = {}
    for h in plain:
        triples.setdefault((h.at, h.effect.name.split("_")[0]), []).append(h)
    rubbing = [h for h in plain if h.effect.name in FRICTION]
    lone = [h for h in plain if h not in rubbing]
    several = [some for some in triples.values() if len(some) > 1]
    return [*((h,) for h in (*free, *lone)), *(tuple(some) for some in (rubbing, *several) if some)]


def margins(lost: float, turns: bool, free: bool, strained: bool) -> tuple[float, float]:
    """Return the nat that a term must promise in the place of what names are worth, and by how many it may fall short.

    Short once it is fitted: of names that only turn slowly, have no law, or break theirs.
    """
    if turns:
        return (1 - TURNS) * lost, TURNS * lost
    if free or strained:
        return (1 - MUCH) * lost, NEEDED if free else CLOSE * lost
    return (1 + CLOSE) * lost, 0.0


def rivals(guesses: Sequence[Guess], fit: Fit, gone: Sequence[Hypothesis]) -> Iterator[Guess]:
    """Yield the best term where effects are, and the best one elsewhere if an effect could as well be there.

    What is slow may be the noise's colour, or a drift, which has a name: such a term is held against that name alone. A
    jump is held against splines without a law as well, for three numbers and a time are no curve, and a slow curve of a
    gyroscope's, which is nothing that a joint does.
    """
    own = {seen_at(h) for h in gone}
    if len(gone) == 1 and gone[0].effect.name in DRIFTS:
        yield from [g for g in guesses if g.term.drift and g.term.at in own][:1]
    steady = [g for g in guesses if not g.term.drift]
    if any(h.effect.states for h in gone):  # it takes what is at either IMU
        if gone[0].effect.free:
            yield from [g for g in guesses if g.term.jumps][:1]
            yield from [g for g in guesses if g.term.drift and not g.term.jumps and g.term.part == "gyro"][:1]
        yield from (next(g for g in steady if g.term.at == at) for at in dict.fromkeys(g.term.at for g in steady))
        return
    best = next((g for g in steady if g.term.at in own), None)
    if best:
        yield best
    if steady and steady[0] is not best and len(gone) == 1:
        (h,) = gone
        if (h.effect.name, steady[0].term.at) in {(r.effect, r.at) for r in alike(fit, h)}:
            yield steady[0]


def seen_at(h: Hypothesis) -> str:
    """Return where a term that stands for an effect would be: at its IMU, or in the torque of a swing."""
    return h.at if h.effect.place == "imu" else "joint"


def breaks_its_law(fit: Fit, h: Hypothesis) -> bool:
    """Return whether an effect's states leave more of their law than it allows, and so are splines.

    Of a gyroscope with hysteresis a filter that broke its law by 2.8 times its std explained 690,000 nat, and a term of
    where the reading came from 212 fewer; a filter's own readings break it by a tenth of its std.
    """
    return any(std > 1.0 for name, std in fit.noise.items() if h.effect.lawful and name.startswith(h.key("")))


def wanders(guesses: Sequence[Guess], gone: Sequence[Hypothesis], lost: float) -> bool:
    """Return whether a curve of time explains as much, were the noise white, as an offset or a drift of `lost` nat.

    Noise as coloured as it may be forbids to believe the curve; it does not make the straight line sure.
    """
    if len(gone) > 1 or gone[0].effect.name not in SLOW:
        return False
    (at, part) = (gone[0].at, gone[0].effect.name.split("_")[0])
    return any(
        g.term.timed and g.term.drift and (g.term.at, g.term.part) == (at, part) and g.white > lost for g in guesses
    )


def only_turns(fit: Fit, h: Hypothesis) -> bool:
    """Return whether a joint's play is a slow turn, as of a mount that creeps: play goes to and fro with the motion.

    Where a slip is in the fit it has taken a step from the turn, or given it one.
    """
    if h.effect.name != "joint_play":
        return False
    turned = np.concatenate([*states_inside(fit.model, fit.state, h).values()], axis=1)
    time = inside(fit.model)
    slips = [fit.state.values[o.key("time")] for o in fit.model.hypotheses if o.effect.name == SLIP]
    slow = np.column_stack([drifts(time), *(time > t for t in slips)])
    off = turned - turned[:1]
    left = off - slow @ np.linalg.lstsq(slow, off, rcond=None)[0]
    return float(np.sum(left**2)) < QUICK * float(np.sum((turned - turned.mean(axis=0)) ** 2))


__all__ = ["MOVED", "MUCH", "SLIP", "SLOW", "breaks_its_law", "groups", "margins", "only_turns", "rivals", "wanders"]
