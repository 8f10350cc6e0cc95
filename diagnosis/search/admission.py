"""What of a round comes into the fit: asked of data that it has not seen."""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.cross_validation import by_halves, heldout_gain
from imubench.diagnosis.criteria.trial import Gain, Kept, Passed, Trial
from imubench.diagnosis.noise.masking import with_mask
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.search.dynamic_candidates import CLEARLY
from imubench.diagnosis.search.moves.add import next_plain, of_a_clock
from imubench.diagnosis.search.moves.move import (
    Answer,
    Foretells,
    Holds,
    Proposal,
    Proposals,
    Refused,
    Round,
    RoundMemory,
    SearchState,
    told,
)
from imubench.diagnosis.solve.levenberg_marquardt import at_noise_of
from imubench.progress import tell

SECOND = 0.5  # of the best's evidence: from there one is asked where the best is refused
AKIN = 0.9  # of the best's evidence, from which on one at its place tells what the best does


@dataclass(frozen=True)
class Add:
    """One round: what explains most comes in if it predicts samples that it was not fitted to.

    If something akin to the best predicts them and the best only seems to, an effect of that kind is there, and the
    best is its name: an effect of many numbers is hard to show on short blocks, one of few is not. An effect of a
    single moment shows in one block only, so it is judged by its law instead (`shows_in_its_moments`). A slip that
    predicts nothing is not asked for again: any loud moment promises a slip, and that hides the other effects.
    """

    tries: Callable[[SearchState, Callable[[str], None]], Round]  # what a round tries

    def propose(self, state: SearchState) -> Proposals:
        """Yield what may come in, best first until one does; then what comes with it; last what the next round asks."""
        now, begun = self.tries(state, tell), state
        refused: Refused = ()
        first: Gain | None = None  # what the best gains
        for trial, least in asked(now.tried):
            best = now.tried[0]
            taken = best if first is not None and stands_for_best(trial, now, first, state) else trial
            answer = yield alone(state, now, trial, taken, least, first)
            if answer.accepted:
                state, refused = answer.state, () if taken is not trial else refused
                if taken is not trial:
                    state.use.fires("akin-for-best")
                if taken is best:
                    state = yield from with_others(state, now.together)
                break
            first = answer.gain if trial is best else first
            refused = (*refused, (trial.hypothesis, answer.gain.value if answer.gain else 0.0))
        else:
            state, refused = yield from all_together(state, now, refused)
        yield Proposal("the end of a round", closed(state, begun, now, refused))


def stands_for_best(trial: Trial, now: Round, first: Gain, state: SearchState) -> bool:
    """Return whether the best of a round, which gained `first`, comes in where a trial gains on left-out data."""
    return state.use.on("akin-for-best") and first.value > 0 and akin(trial, now.tried[0])


def alone(state: SearchState, now: Round, trial: Trial, taken: Trial, least: float, first: Gain | None) -> Proposal:
    """Return the proposal of one effect of a round, `taken` where the one that is asked is another than comes in."""
    h, best = trial.hypothesis, trial is now.tried[0]
    tell(f"predicting held-out data with {h.name}")
    better = now.first if best else with_noise(trial.fit)
    fit = better if taken is trial else now.first
    others = tuple(Passed(t.hypothesis, t.evidence) for t in now.tried if t is not taken and not t.also)

    def after(gain: Gain | None) -> SearchState:
        won = told(gain if taken is trial else first)
        return state.changed(
            fit, [*state.kept, *(Kept(h, taken.evidence, won, others) for h in (taken.hypothesis, *taken.also))]
        )

    def halves() -> Gain:
        gain = by_halves(at_noise_of(now.fit, better), better, state.random)
        if gain.clear():
            state.use.fires("halves-for-blocks")
        return gain

    short = not h.effect.states and state.use.on("halves-for-blocks")  # blocks may be too short to show it
    test = Foretells(
        lambda: heldout_gain(now.fit, better, state.random),
        least,
        halves if short else None,
        trial.evidence,
        anyway=now.brief and best,
    )
    return Proposal(h.name, after, (test,))


def with_others(state: SearchState, together: Sequence[Trial]) -> Generator[Proposal, Answer, SearchState]:
    """Yield what came together with the best, one after the other, while each gains; return the state with them."""
    for trial in together:
        answer = yield one_more(state, trial)
        if not answer.accepted:
            break
        state = answer.state
    return state


def one_more(state: SearchState, trial: Trial) -> Proposal:
    """Return the proposal of an effect beside those that a round has brought already."""
    return Proposal(
        trial.hypothesis.name,
        lambda won: state.changed(trial.fit, [*state.kept, Kept(trial.hypothesis, trial.evidence, told(won), ())]),
        (
            Foretells(lambda: heldout_gain(state.fit, trial.fit, state.random)),
            Holds(lambda: len(state.kept) != ADMISSION.most_effects - 1),
        ),
    )


def all_together(
    state: SearchState, now: Round, refused: Refused
) -> Generator[Proposal, Answer, tuple[SearchState, Refused]]:
    """Yield effects that were found one after the other and each refused alone: they may predict together.

    A slip that is not in the fit spoils what a scale predicts elsewhere, and the scale what the slip predicts. A
    clock's skew does the same to every other effect. Return the state with them, and the effects that are still
    refused.
    """
    rule, together = "add-together", now.together if state.use.on("add-together") else []
    if not together and state.use.on("clock-beside-best"):
        rule, together = "clock-beside-best", with_a_clock(now, tell)
    if not together or len(state.kept) + 1 + len(together) > ADMISSION.most_effects:
        return state, refused
    best, last = now.tried[0], together[-1]
    some = [best.hypothesis, *(t.hypothesis for t in together)]
    tell(f"predicting held-out data with {' and '.join(h.name for h in some)}")
    evidence = [best.evidence, *(t.evidence for t in together)]

    def after(gain: Gain | None) -> SearchState:
        new = [Kept(h, e, told(gain), ()) for h, e in zip(some, evidence, strict=True)]
        return state.changed(last.fit, [*state.kept, *new])

    test = Foretells(lambda: heldout_gain(now.fit, last.fit, state.random))
    answer = yield Proposal(" and ".join(h.name for h in some), after, (test,))
    if not answer.accepted:
        return state, refused
    state.use.fires(rule)
    return answer.state, tuple(r for r in refused if r[0] not in some)


def closed(state: SearchState, begun: SearchState, now: Round, refused: Refused) -> SearchState:
    """Return the state at the end of a round that began with another one: on which samples, and what is asked next."""
    rounds, came = begun.rounds, len(state.kept) > len(begun.kept)
    fit, new = state.fit if came else now.fit, state.kept[len(begun.kept) :]
    if now.fit.model.masks is not begun.fit.model.masks and not any(k.hypothesis.effect.onset for k in new):
        fit = with_mask(fit, begun.fit.model.masks)  # it was of a slip that was refused
    late = any(k.hypothesis.effect.late_by for k in new)
    heard = frozenset() if late else rounds.heard | well_heard(now)
    asked_now = begun.everything if rounds.asked is None else rounds.asked
    again, asked_next = True, rounds.asked
    if came:
        asked_next = None
    elif slips := {h.name for h, _ in refused if h.effect.onset}:
        asked_next = tuple(h for h in asked_now if h.name not in slips)
    elif refused and not now.lively:
        asked_next = tuple(h for h in begun.everything if h.effect.states)
    else:
        again = False
    memory = RoundMemory(again, asked_next, len(begun.kept), came, late, heard, rounds.vain)
    return replace(state, fit=fit, refused=(*begun.refused, *refused), rounds=memory)


def well_heard(now: Round) -> frozenset[str]:
    """Return the filters that were worth much in a round, whatever came in instead."""
    worth = (t for t in now.tried if t.evidence > CLEARLY)
    return frozenset(t.hypothesis.name for t in worth if t.hypothesis.effect.filters)


def asked(tried: list[Trial]) -> list[tuple[Trial, float]]:
    """Return the trials that held-out data are asked about until one is not refused, and the nat each must gain there.

    The best, and the best without states, which a spline that takes in everything hides; with those as good as it. One
    that is less good must gain of what it promises as large a share. Last the best with states, if it was not the best.
    What is nearly as good (`akin`) must only gain: it is asked for what is so like the best.
    """
    plain = [t for t in tried if not t.hypothesis.effect.states]
    out = [(t, 0.0) for t in tried[:1]]
    for t in (t for t in plain if t is not tried[0]):
        if t.evidence > plain[0].evidence - EVIDENCE.needed_nat or akin(t, plain[0]):
            out.append((t, 0.0))
        elif t.evidence > SECOND * plain[0].evidence:
            out.append((t, SECOND * t.evidence))
    return out + [(t, 0.0) for t in tried[1:] if t.hypothesis.effect.states and t.evidence > EVIDENCE.needed_nat][:1]


def akin(trial: Trial, best: Trial) -> bool:
    """Return whether a trial explains at its place nearly as much as the best does."""
    return trial.hypothesis.at == best.hypothesis.at and trial.evidence > AKIN * best.evidence


def with_a_clock(now: Round, say: Callable[[str], None]) -> list[Trial]:
    """Return the clock's error that explains much beside a round's best, if that has no states and explains much."""
    if not now.tried or now.tried[0].hypothesis.effect.states or now.tried[0].evidence < CLEARLY:
        return []
    found = next_plain(now.first, [h for h in now.plain if of_a_clock(h)], say)
    return [found] if found and found.evidence > CLEARLY else []


__all__ = ["Add"]
