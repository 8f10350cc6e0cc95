"""What the README shows works as it stands there."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from imubench.estimate import Estimate
from imubench.listing import known
from imubench.plugins import find_estimator
from imubench.run import simulate
from imubench.score import score
from tests.command import here

README = (Path(__file__).resolve().parent.parent / "README.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


def test_your_own_estimator_in_fifteen_lines(tmp_path, monkeypatch):
    (block,) = (b for b in BLOCKS if "# mine.py" in b)
    assert len(block.splitlines()) <= 15
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(block)
    (spec,) = set(re.findall(r"(mine\.py:\w+)", README))
    mine = find_estimator(spec)
    for scenario, seed in (("hinge-planar", 0), ("hinge-hand", 2), ("hinge-hand", 3), ("hinge-hand", 7)):
        recording, truth = simulate(scenario, seed)
        answer = mine.estimate(recording)
        assert isinstance(answer, Estimate)
        assert answer.value.shape == (2, 3)
        judged = score(answer, truth)  # once 7 of 20 seeds were claimed and wrong, these three among them
        assert answer.pairing == "unknown"
        assert judged.figures["best_pairing_maxae"] < np.deg2rad(0.3)  # 0.25 at most in 40 seeds
        assert "maxae" not in judged.figures


@pytest.mark.long
def test_the_commands_about_your_own_estimator_run(tmp_path, monkeypatch):
    (block,) = (b for b in BLOCKS if "# mine.py" in b)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(block)
    commands = re.findall(r"^imubench ((?:run|estimate) .*mine\.py:\S+.*?) *(?:#.*)?$", README, flags=re.MULTILINE)
    assert len(commands) == 2
    for command in commands:
        done = here(*shlex.split(command.replace("my-recording", "runs/hinge-hand/recording")))
        assert done.code == 0, done.err
        assert "mine.py:estimate (converged)" in done.out


def test_the_python_example_runs(capsys: pytest.CaptureFixture[str]):
    (block,) = (b for b in BLOCKS if "random_hinge" in b)
    exec(block, {})
    figure = re.search(r"'maxae': ([0-9.e-]+)", capsys.readouterr().out)
    assert figure is not None
    assert float(figure[1]) < np.deg2rad(2)


def test_every_name_in_the_commands_is_known():
    names = known()
    for command, kind in (("run", "scenarios"), ("estimate", "estimators"), ("convert", "formats")):
        for match in re.finditer(rf"imubench {command} ([\w/.:-]+)", README):
            assert match[1] in names[kind] or ".py:" in match[1]


def test_every_link_leads_somewhere():
    root = Path(__file__).resolve().parent.parent
    for target in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (root / target).exists(), target


def test_every_test_that_the_list_of_promises_names_is_there():
    folder = Path(__file__).resolve().parent
    named = re.findall(r"`((?:\w+/)*test_\w+\.py)::(\w+)`", (folder / "README.md").read_text())
    assert len(named) > 30
    missing = [f"{file}::{name}" for file, name in named if f"def {name}(" not in (folder / file).read_text()]
    assert missing == []
