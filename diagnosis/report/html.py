"""Pieces of HTML that the report's parts share."""

from collections.abc import Iterable, Sequence

from imubench.glossary import TERMS
from imubench.reproduce.report import escape


def term(name: str, text: str = "") -> str:
    """Return a word of the glossary that says what it means when pointed at; `text` is how it stands in a sentence."""
    return f"<abbr title='{escape(TERMS[name])}'>{escape(text or name)}</abbr>"


def table(columns: Sequence[str], body: Iterable[Sequence[str]], last: int = 3) -> str:
    """Return a table of plain texts; columns 1 to before `last` hold numbers."""
    kind = ["number" if 1 <= i < last else "" for i in range(len(columns))]
    head = "".join(f"<th class='{k}'>{escape(c)}</th>" for k, c in zip(kind, columns, strict=True))
    lines = "".join(
        "<tr>" + "".join(f"<td class='{k}'>{escape(v)}</td>" for k, v in zip(kind, row, strict=True)) + "</tr>"
        for row in body
    )
    return f"<div class='scroll'><table class='narrow'><tr>{head}</tr>{lines}</table></div>"


def fold(summary: str, body: str) -> str:
    """Return a part that is closed until somebody opens it; nothing where its body is empty."""
    return f"<details><summary>{escape(summary)}</summary>{body}</details>" if body else ""


__all__ = ["fold", "table", "term"]
