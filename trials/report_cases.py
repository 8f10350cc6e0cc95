"""The tables of a proof's report that name single cases: failures first, then every one."""

from collections.abc import Callable, Iterable, Sequence

from imubench.reproduce.report import escape
from imubench.trials.replayed import Replayed
from imubench.trials.scoring import CaseScore, missed

FAILURES: dict[str, Callable[[CaseScore], bool]] = {
    "No diagnosis": lambda s: bool(s.failed),
    "Named with confidence what is not there": lambda s: bool(s.wrong),
    "False alarm": lambda s: s.kind == "none" and s.alarm,
    "Missed, though 5 times the bound or more": missed,
    "Found, but with a wrong name or place first": lambda s: s.first_right is False,
    "Two or three effects, not exactly those": lambda s: s.exact is False and not s.failed,
    "Outside the table, not flagged at its place": lambda s: s.located is False and not s.failed,
    "Right name, but the replay is not as near as the fit": lambda s: s.replayed.modelled is False,
    "Right name, but the declared simulation is not worse by what was concealed": lambda s: s.replayed.shown is False,
    "Found, but `where` has another sensor first": lambda s: s.replayed.sensor is False,
}
COLUMNS = ("case", "rig", "kind", "truth", "times its bound", "said", "verdict", "simulation", "s")


def failures(scores: Sequence[CaseScore]) -> str:
    """Return a table of the cases of every kind of failure that there is."""
    parts = []
    for title, is_one in FAILURES.items():
        found = [s for s in scores if is_one(s)]
        if found:
            parts.append(f"<h3>{escape(title)}: {len(found)}</h3>{cases(found)}")
    return "".join(parts) or "<p>None.</p>"


def cases(scores: Iterable[CaseScore]) -> str:
    """Return a table of cases."""
    head = "".join(f"<th>{c}</th>" for c in COLUMNS)
    return f"<div class='scroll'><table><tr>{head}</tr>{''.join(map(_case, scores))}</table></div>"


def _case(s: CaseScore) -> str:
    strength = ", ".join("-" if v is None else f"{v:.3g}" for v in s.strength)
    if s.beyond is not None:
        strength += f"; {s.beyond:.3g} beyond every name, {s.least:.3g} in the least favourable noise"
    cells = (
        s.name,
        s.rig,
        s.kind + ("" if s.observable else ", unobservable"),
        ", ".join(s.truth) or "nothing",
        strength,
        s.failed or ", ".join(s.found) or "nothing",
        s.verdict,
        _simulation(s.replayed),
        f"{s.seconds:.0f}",
    )
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"


def _simulation(r: Replayed) -> str:
    """Return what the simulations of a case were worth, in words."""
    parts = []
    if r.modelled is not None:
        ratios = [f"{x:.3g}" if x is not None else "none" for x in (r.replay, r.disk)]
        kind = "rolled out" if r.rolled_out else "replayed"
        told = "" if r.held_out is not False else ", not all of it held out"
        parts.append(f"{kind}: {ratios[0]} of the fit's misfit, on disk {ratios[1]}{told}")
    if r.channel:
        share = "not told" if r.showed is None else f"{100 * r.showed:.0f} %"
        parts.append(f"shown of what was concealed in {r.channel}: {share}")
    if r.sensor is not None:
        said = {None: "", True: ", channel right", False: ", channel wrong"}[r.first_channel]
        parts.append(f"first sensor {'right' if r.sensor else 'wrong'}{said}")
    return "; ".join(parts)
