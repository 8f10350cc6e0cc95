"""Which effects the fit needs: score all, refit the best few exactly, keep what predicts, drop what it does without."""

from collections.abc import Mapping
from dataclasses import replace

from imubench.diagnosis.candidates.both_mounts import gives_way
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.criteria.dynamic_aic import with_tight_laws
from imubench.diagnosis.criteria.plausible_fit import law_levels, natural
from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.noise.knot_selection import finer
from imubench.diagnosis.noise.masking import weighed_beside
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.rules import RuleUse
from imubench.diagnosis.search.admission import Add
from imubench.diagnosis.search.loop import Repeat, Rule, Stage, search
from imubench.diagnosis.search.moves.drop import Drop, firmly
from imubench.diagnosis.search.moves.merge import Merge
from imubench.diagnosis.search.moves.move import SearchState, Step
from imubench.diagnosis.search.moves.swap_clock_for_backlash import ClocksToBacklash
from imubench.diagnosis.search.moves.swap_clock_for_filter import ClockToFilter
from imubench.diagnosis.search.moves.swap_for_one_triple import FilterOfOneTriple
from imubench.diagnosis.search.moves.swap_for_rival import RivalForEffect
from imubench.diagnosis.search.moves.swap_friction import FrictionMixture, together
from imubench.diagnosis.search.rounding import RoundedStates
from imubench.diagnosis.search.rounds import next_round
from imubench.diagnosis.search.selected import DROP_NEEDLESS, Selection, candidates
from imubench.diagnosis.solve.levenberg_marquardt import converged
from imubench.progress import tell

MOST_LAW_ROUNDS = 8  # rounds at most, of a law that the fit ends with
FURTHER = "further effects"
WITHOUT = "whether each finding is needed"
OTHERWISE = "other readings of the findings: one effect for two, a filter for a delay"
SETTLING = "the last digits of the findings' numbers"


def laws_of_filters(fit: Fit) -> list[str]:
    """Return the noise levels of filters' laws, which have settled once the filter is in.

    A sensor's slow noise behind its filter looks like noise of the law: in every further round more of it would go
    there, without end.
    """
    return law_levels(fit, [h for h in fit.model.hypotheses if h.effect.filters])


def on_finer_knots(state: SearchState) -> SearchState:
    """Return the state on as many knots as its effects ask for, and what was certain before they became more."""
    fine = finer(state.fit)
    return state if fine is state.fit else replace(state, fit=fine, firm=tuple(firmly(state.fit, state.kept)))


def settled_laws(state: SearchState) -> SearchState:
    """Return the state with the noise of springs' and filters' laws estimated to the end."""
    if not state.fit.model.tilts:
        return state
    tell("settling springs and dampers")
    return replace(state, fit=with_tight_laws(with_noise(state.fit, MOST_LAW_ROUNDS, laws_of_filters(state.fit))))


def weighed_moments(state: SearchState) -> SearchState:
    """Return the state in whose fit the moments in which effects act count as much as they tell.

    A slip's course is near enough to find it by, not to read its numbers off; what one that is gone hid counts again.
    """
    seen = weighed_beside(state.fit, [k.hypothesis for k in state.kept], state.sound)
    return state if seen is state.fit else replace(state, fit=with_noise(seen))


def solved(state: SearchState) -> SearchState:
    """Return the state with its fit solved to the end, where it has any effect."""
    return replace(state, fit=converged(state.fit)) if state.kept else state


def gained_together(state: SearchState) -> SearchState:
    """Return the state whose laws of friction are judged together, where there are several."""
    kept = together(state.fit, state.kept)
    return state if kept is state.kept else state.changed(state.fit, kept)


def another_round(state: SearchState) -> bool:
    """Return whether there is room for another effect, and something left to ask."""
    return state.rounds.again and len(state.kept) < ADMISSION.most_effects


def came_in(state: SearchState) -> bool:
    """Return whether an effect came in with the last round."""
    return state.rounds.came


def rubs(state: SearchState) -> bool:
    """Return whether a law of friction came in with the last round."""
    return state.rounds.came and any(k.hypothesis.effect.friction for k in state.came)


def came_late(state: SearchState) -> bool:
    """Return whether a clock's offset came in with the last round."""
    return state.rounds.late


def unnatural(state: SearchState) -> bool:
    """Return whether the settled laws left an effect with numbers that nature does not know."""
    return bool(state.fit.model.tilts) and not all(natural(state.fit, k.hypothesis) for k in state.kept)


ADD_ROUNDS = Repeat(
    (
        Rule("add", Add(next_round)),
        Rule("rival-for-effect", RivalForEffect(), when=came_in),
        Rule("filter-of-one-triple", FilterOfOneTriple(), when=came_in),
        Rule("friction-mixture", FrictionMixture(), when=rubs),
        Rule("quick-filter-for-clock", ClockToFilter(splines=False), when=came_late),
    ),
    again=another_round,
)
STAGES = (
    Stage(
        FURTHER,
        (
            Rule("backlash-for-clocks", ClocksToBacklash()),
            Rule("quick-filter-for-clock", ClockToFilter(splines=False)),
            ADD_ROUNDS,
        ),
    ),
    Stage(
        WITHOUT,
        (
            Rule("finer-knots", Step("more knots", on_finer_knots)),
            DROP_NEEDLESS,
            Rule("rounded-states", RoundedStates()),
            DROP_NEEDLESS,
        ),
    ),
    Stage(
        OTHERWISE,
        (
            Rule("friction-mixture", FrictionMixture()),
            DROP_NEEDLESS,
            Rule("merge", Merge()),
            DROP_NEEDLESS,
            Rule("filter-for-clock", ClockToFilter()),
            DROP_NEEDLESS,
        ),
    ),
    Stage(
        SETTLING,
        (
            Rule("settle-laws", Step("noise of laws", settled_laws)),
            Rule("drop", Drop(), when=unnatural),
            Rule("mask-moments", Step("moments of effects", weighed_moments)),
            Rule("converge", Step("the last digits", solved)),
            Rule("friction-together", Step("friction judged together", gained_together)),
        ),
    ),
)
"""The search from its first rule to its last."""
STAGES_GIVING_WAY = (Stage(WITHOUT, (DROP_NEEDLESS,)),)
"""Where both mounts give way: at least cost springs take in what is not theirs; where they predict best is enough."""


def select(
    nominal: Fit,
    rounding: Mapping[str, float] | None = None,
    use: RuleUse | None = None,
) -> Selection:
    """Return the effects that the recording needs.

    Args:
        nominal: the motion, with what was in the model from the start.
        rounding: nat that a state may gain of it, by place.
        use: the rules that may be applied, and where it is noted which changed something; None: all rules.

    Returns:
        What was found; where the time limit stops the search, what it has by then and what was not tried.
    """
    begun = SearchState(
        nominal,
        tuple(Kept.unjudged(h) for h in nominal.model.judged),
        tuple(candidates(nominal.model)),
        rounding=rounding or {},
        use=use or RuleUse(),
        sound=nominal.model.masks,
    )
    found = search(begun, STAGES_GIVING_WAY if gives_way(nominal) else STAGES)
    return Selection(found.fit, found.kept, (*found.refused, *found.dropped), found.not_tried)


__all__ = ["STAGES", "select"]
