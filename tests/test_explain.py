"""What is explained in plain words: every effect, every figure, every word, on the command line and in the docs."""

import json
from pathlib import Path

import pytest

from imubench.effects import EFFECTS
from imubench.errors import InputError
from imubench.estimators import ESTIMATORS
from imubench.explain import every, explained, glossary_page
from imubench.glossary import FIGURES, TERMS
from imubench.run import simulate
from imubench.score import score
from tests.command import here

DOCS = Path(__file__).resolve().parent.parent / "docs"


def test_everything_is_explained_once():
    names = [one.name.casefold() for one in every()]
    assert len(names) == len(set(names)) == len(EFFECTS) + len(FIGURES) + len(TERMS)
    for one in every():
        assert one.text.endswith("."), one.name
        assert one.text[0].isupper(), one.name
        assert "{" not in one.text, one.name


def test_every_effect_has_words_for_people():
    assert all(effect.phrase for effect in EFFECTS.values())


def test_every_effect_says_its_law_its_place_and_its_numbers():
    found = explained("soft_mount")
    assert found.kind == "effect"
    assert found.text == "A soft mount that a sensor moves on as on springs."
    assert "frequency, 3 numbers: in Hz, in segment axes" in found.details
    assert any(line.startswith("law: f + 2 z w") for line in found.details)
    alike = [(name, alike) for name, effect in EFFECTS.items() for alike in effect.alike]
    assert {one.effect for _, one in alike} <= set(EFFECTS)
    both = {(name, one.effect) for name, one in alike}
    assert {(other, name) for name, other in both} == both  # whichever is asked, both say it


@pytest.mark.parametrize("name", ["Held out", "held-out", "HELD_OUT", " held out "])
def test_a_name_is_known_however_it_is_written(name):
    assert explained(name).text == TERMS["held out"]


@pytest.mark.parametrize(("scenario", "estimator"), [("hinge-hand", "seel2012"), ("pendulum-rigid", "mrvs")])
def test_every_figure_of_a_score_is_explained(scenario, estimator):
    recording, truth = simulate(scenario, seed=1)
    for name in score(ESTIMATORS[estimator].estimate(recording), truth).figures:
        assert explained(name).kind == "figure", name
    assert explained("best_pairing_deviation_imu2") == explained("deviation")


@pytest.mark.parametrize(
    ("name", "kind", "text"),
    [
        ("olsson2020", "estimator", "Hinge axis from gyroscopes and accelerometers, both sign pairings tried."),
        ("olsson2020/motion-11", "scenario", "Motion 11 of Olsson et al. 2020: fast sequential, tilting axis."),
        ("hinge", "rig", "Two segments on a hinge that a screw can lock, free or fixed base, an IMU on each."),
        ("arve", "estimator", "Joint centre, one r a sample: extended Kalman filter on r and the rotation."),
    ],
)
def test_what_is_listed_is_explained_too(name, kind, text):
    found = explained(name)
    assert (found.kind, found.text) == (kind, text)
    assert explained("xsens_mtw").kind == "IMU"


def test_a_name_that_is_none_is_one_line_with_what_is_like_it():
    with pytest.raises(InputError, match=r"unknown name 'soft_mont'; known: .*soft_mount"):
        explained("soft_mont")
    with pytest.raises(InputError, match="unknown name 'qqqqqq'; known: the effects"):
        explained("qqqqqq")


def test_the_page_of_the_docs_is_what_the_glossary_says():
    assert (DOCS / "glossary.md").read_text(encoding="utf-8") == glossary_page(), "run scripts/write_glossary.py"


def test_the_command_explains_and_writes(tmp_path):
    done = here("explain", "misfit", "--out", "out", folder=tmp_path)
    assert done.code == 0, done.err
    assert done.out.startswith("misfit (word): ")
    assert json.loads((tmp_path / "out" / "explain.json").read_text())["text"] == TERMS["misfit"]
    assert here("explain", "misfot", folder=tmp_path).code == 2
