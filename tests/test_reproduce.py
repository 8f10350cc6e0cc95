"""A paper becomes a report: the page, its verdict, exit codes and what is refused."""

import json
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest

from imubench.errors import InputError
from imubench.reproduce import PAPERS
from imubench.reproduce.claims import Judged, Measured
from imubench.reproduce.paper import Figure, Paper, Part, Story, Table
from imubench.reproduce.report import page
from imubench.reproduce.reproduce import reproduce
from tests.command import here
from tests.papers import BOUNDED, SEEN, counted


@contextmanager
def unwatched(parts: list[Part]) -> Iterator[object]:
    yield lambda part: None


def drawn():
    from matplotlib.figure import Figure as Canvas

    canvas = Canvas(figsize=(2, 1))
    canvas.subplots().plot([0, 1], [0, 1])
    return canvas


def small_paper(limit: float) -> Paper:
    claim = replace(BOUNDED, limit=limit, measure="worst", claim="The error is < 2 deg & finite")
    return Paper(
        name="small",
        summary="a paper",
        citation="Somebody, Somewhere",
        claims=(claim, replace(SEEN, name="seen", measure="seen")),
        measures={"worst": lambda r: Measured(r, "of noise"), "seen": lambda r: Measured(r, "the rig is rigid")},
        settings=lambda quick, seed: (quick, seed),
        parts=lambda s: [Part("p", "sum", 1.0, counted, {"n": 1, "log": os.devnull})],
        gather=lambda s, done: float(done["p"]["square"][0]),
        tell=lambda r: Story(
            "Once upon a time",
            (
                Figure("f1", "Figure 1", "It goes up", "A line.", drawn),
                Table("t1", "Table 1", "It is one", "A number.", ("a", "b"), (("1", "2"),)),
            ),
            ("A note",),
        ),
    )


@pytest.mark.parametrize(("limit", "verdict"), [(2.0, "holds"), (0.5, "fails")])
def test_a_paper_becomes_claims_and_a_page_of_its_own(tmp_path, monkeypatch, limit, verdict):
    monkeypatch.setitem(PAPERS, "small", small_paper(limit))
    judged = reproduce("small", tmp_path / "out", quick=True, seed=0, watch=unwatched, workers=0).judged
    assert [j.verdict for j in judged] == [verdict, "differs"]
    assert [j["verdict"] for j in json.loads((tmp_path / "out" / "claims.json").read_text())] == [verdict, "differs"]
    text = (tmp_path / "out" / "report.html").read_text()
    for words in (
        "It goes up",
        "It is one",
        "Once upon a time",
        "A note",
        "the rig is rigid",
        "&lt; 2 deg &amp; finite",
    ):
        assert words in text
    block = "class='verdict bad'" if verdict == "fails" else "class='verdict good'"
    assert text.index("</h1>") < text.index(block) < text.index("What was done")  # the verdict comes first
    assert re.findall(r"<img alt='[^']*' src='data:image/png;base64,[A-Za-z0-9+/=]{400,}'>", text)
    assert not re.search(r"(src|href)=.(?!data:|#)", text)  # nothing from elsewhere
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_the_headline_counts():
    judged = [Judged(BOUNDED, Measured(1.0, "x"), v) for v in ("holds", "holds", "fails", "differs")]
    text = page(small_paper(1.0), Story("s", ()), judged, "how", "footer")
    assert "2 of 4 claims hold, 1 fails, 1 figure differs" in text


def test_exit_codes(tmp_path, monkeypatch, capsys):
    from imubench.commands.work.reproduce import run
    from imubench.terminal import Terminal

    for limit, code in ((2.0, 0), (0.5, 1)):
        monkeypatch.setitem(PAPERS, "small", small_paper(limit))
        monkeypatch.setattr("imubench.reproduce.reproduce.cores", lambda: 0)
        assert run("small", tmp_path / f"out{code}", True, 0, Terminal(), Terminal(stderr=True)) == code
        assert ("fails" in capsys.readouterr().out) == bool(code)


def test_an_unknown_paper_is_exit_code_2(tmp_path):
    done = here("reproduce", "olson2020", "--out", "out", folder=tmp_path)
    assert done.code == 2
    assert "unknown paper 'olson2020'; known: olsson2020" in done.err
    assert list(tmp_path.iterdir()) == []


def test_without_matplotlib_one_line_says_so(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError, match=r"figures: expected matplotlib, got none; pip install 'imubench\[plot\]'"):
        reproduce("olsson2020", tmp_path / "out", quick=True, seed=0, watch=unwatched)
    assert list(tmp_path.iterdir()) == []
