"""Docstrings of the diagnosis that tell of a past run."""

import ast
import re

from .rooms import House

PAST = re.compile(
    r"\b(was|were|had|did|came|took|gained|lost|left|gave|promised|explained|became|fell|rose|grew|cost|needed|named)\b"
)
FIGURE = re.compile(r"(?<![\w.^'])\d[\d,.]*(?![\w'])")


def past_figures(house: House) -> list[str]:
    """Return the docstrings with a figure of a past run: a sentence with a number and a verb in the past tense."""
    found = []
    for m in house.modules.values():
        for node in ast.walk(m.tree):
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
                sentences = re.split(r"(?<=[.:;])\s", ast.get_docstring(node) or "")
                if any(PAST.search(s) and FIGURE.search(s) for s in sentences):
                    found.append(f"{m.name}:{getattr(node, 'name', '')}")
    return found
