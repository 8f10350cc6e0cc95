"""The pages of the documents: links lead somewhere, the explanations stay short, and figures told twice agree."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted(p for folder in ("", "docs", "lab", "benchmarks", "tests") for p in (ROOT / folder).glob("*.md"))
LIMITS = {"diagnosis.md": 3000, "proof.md": 1500}  # words, as `wc -w` counts them: what a reader takes in one sitting


def anchors(page: Path) -> set[str]:
    """Return the anchors that GitHub makes of a page's headings."""
    heads = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.strip().lower()).replace(" ", "-") for h in heads}


def links(page: Path) -> Iterator[tuple[Path, str]]:
    """Yield the files of the repository that a page links to, each with the anchor."""
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if not re.match(r"[a-z]+:", target):
            path, _, anchor = target.partition("#")
            yield (page.parent / path if path else page), anchor


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_every_link_leads_somewhere(page: Path):
    for target, anchor in links(page):
        assert target.exists(), target
        if anchor and target.suffix == ".md":
            assert anchor in anchors(target), f"{target}#{anchor}"


@pytest.mark.parametrize(("name", "most"), LIMITS.items())
def test_an_explanation_is_read_in_one_sitting(name: str, most: int):
    assert len((ROOT / "docs" / name).read_text(encoding="utf-8").split()) <= most


def test_every_page_of_the_notebook_is_dated_and_in_its_list():
    listed = dict(re.findall(r"^\| \[(\d{3})\]\(([^)]+)\)", (ROOT / "lab" / "README.md").read_text(), re.MULTILINE))
    pages = sorted(p for p in (ROOT / "lab").glob("*.md") if p.name != "README.md")
    assert list(listed.values()) == [p.name for p in pages]
    for number, page in zip(listed, pages, strict=True):
        head = page.read_text(encoding="utf-8").splitlines()[0]
        assert re.fullmatch(rf"# {number}: .+ \(\d{{4}}-\d\d-\d\d\)", head), head


def test_the_readme_has_the_figures_of_the_latest_run():
    proof = (ROOT / "docs" / "proof.md").read_text(encoding="utf-8")
    lines = [line.strip("|").split("|") for line in proof.splitlines() if line.startswith("|")]
    table = {cells[0].strip(): cells for cells in lines}

    def hits(figure: str) -> tuple[int, int]:
        return int(re.findall(r"\((\d+)", table[figure][1])[0]), int(table[figure][3])

    silent = re.findall(r"(\d+) of (\d+)", table["false alarms: white, coloured, misdeclared"][1])
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    told = re.search(
        r"last (\d+) recordings .* silent on all (\d+) with nothing wrong, saw all (\d+) lone .* first in (\d+) of "
        r"(\d+), named two or three effects exactly in (\d+) of (\d+), flagged (\d+) of (\d+) disturbances .* sure "
        r"of in (\d+)",
        readme,
    )
    assert told is not None
    everything, quiet, strong, first, alarmed, exact, several, flagged, strange, wrong = map(int, told.groups())
    assert hits("cases answered") == (everything, everything)
    assert (sum(int(alarms) for alarms, _ in silent), sum(int(n) for _, n in silent)) == (0, quiet)
    assert hits("detected, 10 times the bound or more") == (strong, strong)
    assert hits("right name and place first") == (first, alarmed)
    assert hits("two or three effects exactly") == (exact, several)
    assert hits("outside the table flagged, and located") == (flagged, strange)
    assert hits("confidently wrong") == (wrong, everything)
