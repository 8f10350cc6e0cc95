"""Beyond the paper: section 8.3 again in other sessions, to tell the method from the luck of one recording."""

import numpy as np

from imubench.reproduce.olsson2020.measures_acceptance import rates_elsewhere
from imubench.reproduce.olsson2020.published import claim_measured_by
from imubench.reproduce.olsson2020.results import Results
from imubench.reproduce.olsson2020.settings import E_MAX, N_MINS, SEQUENCES
from imubench.reproduce.paper import Table

COLUMNS = (
    "sequence",
    "n_min",
    "paper, %",
    "this session, %",
    "other sessions: mean, %",
    "worst, %",
    "all right in",
    "never accepted",
)


def exhibit(r: Results) -> Table:
    """Return the rates of right estimates in this session and in others."""
    rows, all_right = [], []
    for name in SEQUENCES:
        for n_min in N_MINS:
            rates = rates_elsewhere(r, name, n_min)
            never = sum(int((runs.accepted(E_MAX, n_min) < 0).sum()) for runs in r.elsewhere[name])
            right = sum(rate == 100.0 for rate in rates)
            if n_min == max(N_MINS):
                all_right.append(str(right))
            here = 100.0 * r.runs[name].success(E_MAX, n_min)
            paper = claim_measured_by(f"success_{n_min}_{name}").published
            mean, worst = (f"{f(rates):.0f}" if rates else "–" for f in (np.mean, np.min))
            row = (name[-1], str(n_min), f"{paper:.0f}", "–" if np.isnan(here) else f"{here:.0f}")
            rows.append((*row, mean, worst, f"{right} of {len(rates)}", f"{never} runs"))
    listed = ", ".join(all_right)
    finding = (
        f"With n_min = 10 no estimate was wrong in {listed} of {r.settings.sessions} other sessions (sequences 1 to 4)"
    )
    text = (
        f"Section 8.3 (N_max = 1000, E_max = 3 deg) in {r.settings.sessions} more sessions, each with motions, "
        "rest postures, "
        f"sensor errors and noise drawn anew, {r.settings.session_runs} runs each. Right: both axes within 3 "
        "deg of the truth. "
        "A rate that swings from session to session is a property of a recording, not of the method."
    )
    return Table("sessions", "Beyond the paper", finding, text, COLUMNS, tuple(rows))
