"""What an effect, a figure or a word of a result means, in plain words, and docs/glossary.md made of the same."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from imubench.diagnosis.report.words import called
from imubench.effects import EFFECTS, VARIANTS
from imubench.effects.effect import Effect
from imubench.errors import InputError, shortened, unknown
from imubench.glossary import FIGURES, TERMS

PLACES = {
    "imu": "at a sensor, imu1 or imu2",
    "joint": "at the joint",
    "body": "at the swinging body",
    "world": "everywhere",
}
KINDS = {"profiles": "IMU", "claims": "paper"}
"""What one of a kind of `imubench list` is called, where that is not the kind without its s."""


@dataclass(frozen=True)
class Explanation:
    """What a name means."""

    name: str
    kind: str  # effect, figure, word; or what `imubench list` has: rig, scenario, estimator, ...
    text: str  # a sentence or more
    details: tuple[str, ...] = ()  # a line each


def explained(name: str) -> Explanation:
    """Return what a name means; `-`, `_`, spaces and capitals count alike, and what a figure is of may follow it.

    Raises:
        InputError: for a name that is none, with those that are like it.
    """
    known = {_plain(one.name): one for one in every()}
    asked = _plain(name)
    if asked in known:
        return known[asked]
    base = re.sub(r" (imu|segment ?)\d+$", "", asked.removeprefix("best pairing "))
    if base in known and known[base].kind == "figure":
        return known[base]
    listed = _listed(name)
    if listed is not None:
        return listed
    names = [one.name for one in every()]
    close = get_close_matches(_plain(name), [_plain(n) for n in names], n=5, cutoff=0.5)
    if close:
        raise unknown("name", name, [n for n in names if _plain(n) in close])
    raise InputError(
        f"unknown name '{shortened(name, 60)}'; known: the effects of `imubench list`, the figures of a result, and "
        "the words of docs/glossary.md"
    )


def _listed(name: str) -> Explanation | None:
    """Return what `imubench list` says of a rig, a scenario, an estimator, an IMU, a format or a paper."""
    from imubench.listing import known  # which loads what can be played and estimated

    for kind, entries in known().items():
        if name in entries:
            text = entries[name].rstrip(".")
            details = DETAILS[kind](name) if kind in DETAILS else ()
            return Explanation(name, KINDS.get(kind, kind.removesuffix("s")), f"{text[:1].upper()}{text[1:]}.", details)
    return None


def _options(name: str) -> tuple[str, ...]:
    """Return the options of a format that can be converted, a line each."""
    from imubench.convert import find_converter

    return tuple(f"--option {key}=...: {option.help}" for key, option in find_converter(name).options.items())


def _frames(name: str) -> tuple[str, ...]:
    """Return a rig's segments and where their IMUs sit, a line each."""
    from imubench.models import RIG_FILES
    from imubench.models.outside import find_rig
    from imubench.models.tree import rig_tree

    lines = [] if name in RIG_FILES else [find_rig(name).summary]
    for segment in rig_tree(name).segments:
        held = ", ".join(f"{joint.name} ({joint.kind})" for joint in segment.joints) or "the world"
        for imu in segment.imus:
            place, turn = ([round(v, 6) + 0.0 for v in values] for values in (imu.position, imu.quaternion))
            lines.append(f"{segment.name} on {held}; {imu.name} at {place} m, quaternion {turn} (sensor -> segment)")
    return tuple(lines)


DETAILS = {"formats": _options, "rigs": _frames}
"""By kind of `imubench list`: what there is to say beside the line."""


def every() -> Iterator[Explanation]:
    """Yield everything that can be explained."""
    for name, effect in EFFECTS.items():
        yield of_effect(name, effect)
    for name, text in FIGURES.items():
        yield Explanation(name, "figure", text)
    for name, text in TERMS.items():
        yield Explanation(name, "word", text)


def of_effect(name: str, effect: Effect) -> Explanation:
    """Return what an effect is, its law and its numbers."""
    place = effect.place
    text = called(name, "imu1" if place == "imu" else place).replace("imu1", "a sensor")
    details = [f"acts {PLACES[place]}", f"law: {effect.law}"]
    for p in effect.parameters:
        if p.reported:
            count = int(np.prod(p.shape, dtype=int))
            many = f", {count} numbers" if count > 1 else ""
            axes = f", in {p.axes} axes" if count > 1 else ""
            details.append(f"{p.name}{many}: in {'no unit' if p.unit == '1' else p.unit}{axes}")
    for f in effect.found:
        details.append(f"{f.name}: in {'no unit' if f.unit == '1' else f.unit}")
    if same := always_alike(effect):
        details.append(f"no motion tells it from: {same}")
    return Explanation(name, "effect", f"{text[:1].upper()}{text[1:]}.", tuple(details))


def always_alike(effect: Effect) -> str:
    """Return what no motion tells an effect from, in words; empty where there is nothing."""
    return "; ".join(alike.words for alike in effect.alike if alike.words)


def _plain(name: str) -> str:
    return name.casefold().replace("_", " ").replace("-", " ").strip()


@VARIANTS.ours_alone()
def glossary_page() -> str:
    """Return docs/glossary.md."""
    lines = [
        "# Glossary",
        "",
        "What the words, figures and effects of a result mean. Made by `python scripts/write_glossary.py`; "
        "`imubench explain NAME` says the same in a terminal.",
    ]
    titles = {"word": "Words", "figure": "Figures", "effect": "Effects"}
    for kind, title in titles.items():
        lines += ["", f"## {title}", ""]
        some = sorted((one for one in every() if one.kind == kind), key=lambda one: one.name.casefold())
        for one in some:
            text = " ".join([one.text, *(f"{d[:1].upper()}{d[1:]}." for d in one.details)])
            lines.append(f"- **{one.name}**: {_cell(text)}")
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    """Return text whose signs Markdown does not take for its own."""
    return "".join(f"\\{c}" if c in "*_|`<" else c for c in text)


__all__ = ["Explanation", "always_alike", "every", "explained", "glossary_page"]
