"""What docs/your-tissue.md shows works as it stands there, and says everything there is."""

import re
from pathlib import Path

import pytest

from imubench.figures import FIGURES
from imubench.sweeps.axis import KEYS
from imubench.sweeps.spec import OWN, STORAGE, load_sweep, parse_sweep
from imubench.sweeps.tables import FAILURES

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs/your-tissue.md").read_text()
EXAMPLE = ROOT / "benchmarks/your_tissue/sweep.toml"
SPEC, PIECE = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)
(BLOCK,) = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)


def test_the_example_is_the_one_that_made_the_picture():
    assert EXAMPLE.read_text() == SPEC
    found = load_sweep(EXAMPLE)
    assert found.shape == (12, 8)
    assert found.recordings == 20


def test_the_sweeps_of_the_paper_s_motions_are_sweeps():
    files = sorted((ROOT / "docs/examples/sweeps").glob("*.toml"))
    assert [load_sweep(file).shape for file in files] == [(6, 6), (9, 1), (7, 5)]
    for file in files:
        assert f"examples/sweeps/{file.name}" in PAGE


def test_the_piece_is_a_sweep_with_a_rig_and_a_limit():
    found = parse_sweep({"sweep.toml": f"limit_deg = 2\n[[rig]]\nfamily = 'hinge'\n{PIECE}".encode()})
    assert found.axes[0].in_spec == (0.0, 0.01, 0.02, 0.05, 0.1)


def test_the_python_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sweep.toml").write_text(SPEC)
    space: dict[str, object] = {}
    exec(BLOCK, space)
    assert space["recording"].name == "foam-under-both-imus-0000007"
    assert "axis" not in (tmp_path / "cell.toml").read_text()


@pytest.mark.parametrize("key", [*OWN[1:], *STORAGE, *KEYS, *FAILURES, *FIGURES])
def test_every_key_and_figure_is_told(key):
    assert f"`{key}`" in PAGE
