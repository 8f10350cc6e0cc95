"""A proof as one HTML file that needs nothing else: figures, failures first, every case."""

from collections import Counter
from collections.abc import Callable, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING

from imubench.reproduce.paper import Figure as Drawn
from imubench.reproduce.report import escape, png
from imubench.trials import drawings
from imubench.trials.crime import compared
from imubench.trials.detection import by_strength
from imubench.trials.figures import Figure, figures, numbers, reliability
from imubench.trials.report_cases import cases, failures

if TYPE_CHECKING:
    from imubench.trials.prove import Proof

STYLE = (
    ".open { color: var(--differs); } .none { color: var(--soft); } td { max-width: 30rem; overflow-wrap: anywhere; }"
)
OUTSIDE = ("outside_flagged", "outside_located", "strange_flagged", "strange_located")
ALL = ("diagnosis", "residual size", "L1", "oracle")
COMPARED = {  # which ways are asked: the oracle is told the name, the residual's size has none
    **dict.fromkeys(("false_alarms_white", "false_alarms_coloured", "false_alarms_misdeclared"), ALL[:3]),
    **dict.fromkeys(("behind_theory", "detected_strong"), ALL),
    **dict.fromkeys(("first_right", "in_set", "confidently_wrong"), ("diagnosis", "L1")),
    "exact_sets": ("diagnosis", "L1", "oracle"),
    **dict.fromkeys(OUTSIDE, ("diagnosis", "residual size")),
    **dict.fromkeys(("error_over_bound", "error_over_bound_mounts", "covered"), ("diagnosis", "oracle")),
}
WAYS = (
    "Residual size: the misfit alone. L1: all effects without states at once, sparse. Oracle: told the effects, fitted "
    "exactly, found where the evidence asks for it; what it misses the data do not show."
)
CRIME = (
    "Shares as numbers from 0 to 1, over the cases that were played both ways: effects, places, strengths, levels of "
    "noise and declared facts are the same, the motion is the simulator's."
)


def page(proof: "Proof") -> str:
    """Return the report; raises `InputError` where matplotlib is not installed."""
    style = (files("imubench.reproduce") / "report.css").read_text(encoding="utf-8") + STYLE
    s = proof.settings
    asked = [f for f in proof.figures if f.verdict != "none"]
    met = sum(f.verdict == "holds" for f in asked)
    source = "--real DIR" if s.real else f"--cases {s.cases} --seed {s.seed}"
    again = f"imubench prove {source}" + (f" --seconds {s.seconds:g}" if s.seconds else "")
    parts = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'><title>blind trials</title>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f"<style>{style}</style></head><body>",
        f"<h1>{met} of {len(asked)} aims hold in {len(proof.scores)} blind cases</h1>",
        f"<p class='soft'>{escape(_how(proof))}</p>",
        _refused(proof),
        "<h2>Figures</h2>" + _figures(proof.figures),
        "<h2>Detection against strength</h2>",
        _drawing(lambda: drawings.detection(by_strength(proof.scores), proof.scores), drawings.DETECTION),
        "<h2>Is the stated confidence right?</h2>",
        _drawing(lambda: drawings.reliability(reliability(proof.scores)), drawings.RELIABILITY),
        "<h2>Beside other ways, on the same cases</h2>" + _beside(proof),
        _left_out(proof),
        _crime(proof),
        "<h2>Failures</h2>" + failures(proof.scores),
        "<h2>Every case</h2>" + cases(proof.scores),
        f"<footer>{escape(again)}; SHA-256 of commitments.json: {proof.sealed}</footer></body></html>\n",
    ]
    return "\n".join(parts)


def _how(proof: "Proof") -> str:
    how = proof.how
    where = "and namespaces without other processes and network" if how["namespaces"] else "(no namespaces here)"
    return f"Every truth was sealed before the first diagnosis. Each diagnosis: {how['separation']} {where}."


def _refused(proof: "Proof") -> str:
    items = "".join(
        f"<p><b class='fails'>cheat</b> case {n}: {escape('; '.join(what))}</p>" for n, what in proof.refused.items()
    )
    return f"<div class='verdict bad'>{items}</div>" if items else ""


def _figures(figures: Sequence[Figure]) -> str:
    head = "".join(f"<th>{c}</th>" for c in ("verdict", "figure", "here", "95 % interval", "n", "aim", "guard"))
    rows = "".join(
        f"<tr><td class='verdict-cell {f.verdict}'>{'' if f.verdict == 'none' else f.verdict}</td>"
        f"<td>{escape(f.title)}</td><td class='number'>{numbers(f)[0]}</td><td class='number'>{numbers(f)[1]}</td>"
        f"<td class='number'>{f.n}</td><td class='number'>{escape(f.aim)}</td>"
        f"<td class='number {'fails' if f.passed else ''}'>{escape(f.guard)}</td></tr>"
        for f in figures
    )
    words = "<p class='soft'>open: missed, but the interval still reaches the aim: too few cases to tell.</p>"
    return f"<div class='scroll'><table><tr>{head}</tr>{rows}</table></div>{words}"


def _beside(proof: "Proof") -> str:
    ways = {"diagnosis": proof.figures, **{name: figures(scores) for name, scores in proof.beside.items()}}
    head = "<th>figure</th>" + "".join(f"<th class='number'>{escape(way)}</th>" for way in ways)
    rows = ""
    for k, figure in enumerate(proof.figures):
        if figure.name in COMPARED:
            cells = "".join(
                f"<td class='number'>{numbers(of[k])[0] if way in COMPARED[figure.name] else ''}</td>"
                for way, of in ways.items()
            )
            rows += f"<tr><td>{escape(figure.title)}</td>{cells}</tr>"
    return f"<div class='scroll'><table><tr>{head}</tr>{rows}</table></div><p class='soft'>{escape(WAYS)}</p>"


def _left_out(proof: "Proof") -> str:
    if not proof.left_out:
        return ""
    kept = [f for f in figures(proof.left_out) if f.name in ("confidently_wrong", *OUTSIDE[:2])]
    return "<h2>The effect taken out of the library</h2>" + _figures(kept) + cases(proof.left_out)


def _crime(proof: "Proof") -> str:
    if not proof.simulated:
        return ""
    rows = "".join(
        f"<tr><td>{escape(row['title'])}</td>"
        + "".join(f"<td class='number'>{_number(row[k])}</td>" for k in ("generator_value", "sim_value", "difference"))
        + f"<td class='number'>{row['generator_n']}, {row['sim_n']}</td></tr>"
        for row in compared(proof.scores, proof.simulated)
        if row["generator_n"] or row["sim_n"]
    )
    head = "".join(f"<th>{c}</th>" for c in ("figure", "generator", "own simulator", "difference", "n"))
    left = Counter(proof.not_simulated.values()).most_common()
    words = f"<p class='soft'>{escape(CRIME)} Not played: {escape(', '.join(f'{why} ({n})' for why, n in left))}.</p>"
    title = "<h2>The inverse crime: the same questions from the project's own simulator</h2>"
    return f"{title}<div class='scroll'><table><tr>{head}</tr>{rows}</table></div>{words}{cases(proof.simulated)}"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _drawing(draw: Callable[[], object], text: str) -> str:
    figure = Drawn(name="drawing", label="", finding="", draw=draw, text=text)  # type: ignore[arg-type]
    return f"<img alt='{escape(text)}' src='{png(figure)}'><p class='soft'>{escape(text)}</p>"
