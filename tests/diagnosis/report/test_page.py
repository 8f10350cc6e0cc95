"""The page of a diagnosis is one file that nobody breaks, in words that its glossary has."""

import re
from dataclasses import replace

from imubench.diagnosis.report import Paths, page
from imubench.diagnosis.result import Doubt
from imubench.glossary import TERMS
from tests.diagnosis.report.diagnoses import Balanced, simulated
from tests.diagnosis.test_diagnosis_result import diagnosis, evidence


def test_the_page_is_one_file_whose_tags_close_and_that_loads_nothing():
    for d, shown in (simulated(), (diagnosis(), evidence())):
        html = page(d, shown)
        found = Balanced(html)
        assert (found.wrong, found.open, found.loads) == ([], [], [])
        assert "url(" not in html and "@import" not in html and "<script" not in html
        assert "prefers-color-scheme: dark" in html and "max-width: 640px" in html
        assert len(html) < 200_000  # bytes: a mail takes it


def test_names_from_strangers_are_escaped():
    evil = "<img src=x onerror=alert(1)>"
    d, shown = simulated(recording=evil, doubts=(Doubt(evil, evil),), verdict="partly explained")
    html = page(d, replace(shown, notes=(evil,)), Paths(evil, evil))
    assert "<img" not in html
    assert Balanced(html).wrong == []


def test_what_is_a_nat_and_a_misfit_stays_in_what_is_folded():
    d, shown = simulated()
    html = page(d, shown)
    unfolded = re.sub(r"<details>.*?</details>", "", html, flags=re.DOTALL)
    unfolded = re.sub(r"<style>.*?</style>|title='[^']*'", "", unfolded, flags=re.DOTALL)
    for word in (" nat", "knot", "Misfit", "Bayes"):
        assert word not in unfolded, word
    assert "Misfit" in html and "nat</abbr>" in html


def test_every_word_that_the_page_explains_is_in_the_glossary():
    html = page(*simulated())
    told = set(re.findall(r"<abbr title='([^']*)'", html))
    assert len(told) >= 5
    every = {t.replace("'", "&#x27;") for t in TERMS.values()}
    assert told <= every
