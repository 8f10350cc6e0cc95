"""docs/effects.md says of every effect what its law, place and parameters are."""

import pytest

from imubench.effect_reference import prior_of, section, shape_of
from imubench.effects import EFFECTS
from imubench.effects.effect import Parameter


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_has_its_law_place_and_parameters_with_units(name: str):
    effect = EFFECTS[name]
    lines = list(section(name, effect))
    assert lines[0] == f"### {name}"
    assert lines[2].endswith(".")  # the phrase for people, a sentence
    assert f"- law: `{effect.law}`" in lines
    for p in (*effect.parameters, *effect.found):
        (row,) = (line for line in lines if line.startswith(f"| `{p.name}`"))
        assert f"| {'-' if p.unit == '1' else p.unit} |" in row


@pytest.mark.parametrize(
    ("parameter", "words"),
    [
        (Parameter("bias", (3,), "m/s^2", 0.5), "0 +- 0.5"),
        (Parameter("c", (), "N m s/rad", 0.05, sided=True), "0 +- 0.05, not negative"),
        (Parameter("frequency", (3,), "Hz", 0.7, start=10.0, log=True), "10, within a factor of 2"),  # exp(0.7) = 2.01
        (Parameter("axis", (2,), "1", 1.0, start=(0.0, 2.0)), "(0, 2) +- 1"),
    ],
)
def test_a_prior_in_words(parameter: Parameter, words: str):
    assert prior_of(parameter) == words


def test_a_shape_in_words():
    assert [shape_of(shape) for shape in ((), (3,), (3, 3), (None, 2))] == ["1", "3", "3 x 3", "n x 2"]
