"""One move of the search, asked by itself."""

from collections.abc import Sequence
from typing import Any

from imubench.diagnosis.criteria.trial import Kept
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.search.loop import Rule, Search
from imubench.diagnosis.search.moves.move import Move, SearchState


def moved(move: Move, fit: Fit, kept: Sequence[Kept], **known: Any) -> SearchState:
    """Return the state after a move's proposals were decided; begun with a fit, its effects and what else is known."""
    search = Search(SearchState(fit, tuple(kept), **known))
    search.ask(Rule("add", move))  # any name of a rule
    return search.state
