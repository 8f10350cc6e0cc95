"""What the README shows works as it stands there."""

import re
from pathlib import Path

import numpy as np
import pytest

from imubench.estimate import Estimate
from imubench.listing import known
from imubench.run import simulate

README = (Path(__file__).resolve().parent.parent / "README.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


def test_your_own_estimator_in_fifteen_lines():
    (block,) = (b for b in BLOCKS if "estimators/mine.py" in b)
    assert len(block.splitlines()) <= 15
    space: dict[str, object] = {}
    exec(block, space)
    answer = space["estimate"](simulate("hinge-planar", 0)[0])  # type: ignore[operator]
    assert isinstance(answer, Estimate)
    assert answer.value.shape == (2, 3)


def test_the_python_example_runs(capsys: pytest.CaptureFixture[str]):
    (block,) = (b for b in BLOCKS if "random_hinge" in b)
    exec(block, {})
    figure = re.search(r"'maxae': ([0-9.e-]+)", capsys.readouterr().out)
    assert figure is not None
    assert float(figure[1]) < np.deg2rad(2)


def test_every_name_in_the_commands_is_known():
    names = known()
    for command, kind in (("run", "scenarios"), ("estimate", "estimators"), ("convert", "formats")):
        for match in re.finditer(rf"imubench {command} ([\w-]+)", README):
            assert match[1] in names[kind]


def test_every_link_leads_somewhere():
    root = Path(__file__).resolve().parent.parent
    for target in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (root / target).exists(), target
