"""The pytest plugin: each claim is a test; nobody without claims notices it."""

import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from tests.claimed import AXIS, written

SOON = AXIS + 'over = "median"\nconfidence = 0.9\npower = 0.9\nbaseline_power = 0.9\n'
EXACT = SOON.replace("axis", "exact").replace("2 deg", "0.001 deg")
PLUGIN = ("-p", "imubench.checks.pytest_plugin")


def pytest_in(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Return what pytest came to in a folder, with the plugin named: this environment may be older than it."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:imubench_claims", *PLUGIN, *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)


@pytest.mark.long
def test_a_claim_is_a_test_with_a_failure_that_can_be_read(tmp_path):
    written(tmp_path, SOON + EXACT)
    done = pytest_in(tmp_path, "--imubench-claims", "-q", "--junitxml", "junit.xml")
    assert done.returncode == 1, done.stdout + done.stderr
    assert "1 failed, 1 passed" in done.stdout
    assert "fails: best_pairing_rmsae of seel2012 on quick: median <= 0.001 deg\nmedian 0." in done.stdout
    assert "Traceback" not in done.stdout
    (suite,) = ElementTree.parse(tmp_path / "junit.xml").getroot()
    assert [case.get("name") for case in suite] == ["axis", "exact"]
    named = {p.get("name"): p.get("value") for p in suite[0].iter("property")}
    assert int(named["runs"]) >= 1
    assert named["measured"].startswith("median 0.")


@pytest.mark.long
def test_claims_that_nobody_asks_for_are_left_alone(tmp_path):
    written(tmp_path, SOON)
    (tmp_path / "test_it.py").write_text(
        "import sys\n\n\ndef test_it():\n    assert not [m for m in sys.modules if m.startswith('imubench.checks.c')]\n"
    )
    done = pytest_in(tmp_path, "-q")
    assert "1 passed" in done.stdout, done.stdout
    (tmp_path / "other_claims.toml").write_text("[somebody]\nelse = 1\n")  # such as a paper's
    done = pytest_in(tmp_path, "--imubench-claims", "--collect-only", "-q")
    assert "claims.toml::axis" in done.stdout
    assert "other_claims" not in done.stdout


@pytest.mark.long
def test_a_file_that_is_named_is_collected_and_a_mistake_in_it_is_a_line(tmp_path):
    written(tmp_path, SOON.replace("2 deg", "2 mm"))
    done = pytest_in(tmp_path, "claims.toml", "-q")
    assert done.returncode == 2
    assert "claims.toml: claim.axis.at_most 'mm'; known: rad, deg, mrad" in done.stdout


def test_the_plugin_is_offered_to_pytest_and_imports_nothing_heavy():
    import tomllib

    root = Path(__file__).resolve().parent.parent
    offered = tomllib.loads((root / "pyproject.toml").read_text())["project"]["entry-points"]["pytest11"]
    assert offered == {"imubench_claims": PLUGIN[1]}
    heavy = "[m for m in ('numpy', 'mujoco', 'scipy') if m in sys.modules]"
    code = f"import sys, imubench.checks.pytest_plugin; print({heavy})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.long
def test_a_baseline_is_compared(tmp_path):
    import json

    from imubench.checks.check import check
    from imubench.checks.outputs import claims_content
    from imubench.checks.runs import running
    from tests.claimed import loaded

    with running(1, None) as runs:
        done = check(loaded(tmp_path, SOON), runs, least=40)
    entries = claims_content(done, "claims.toml")
    baseline = tmp_path / "baseline.json"
    baseline.write_text(json.dumps(entries))
    assert pytest_in(tmp_path, "claims.toml", "-q", "--imubench-against", "baseline.json").returncode == 0
    entries[0]["errors"] = [e / 2 for e in entries[0]["errors"]]
    baseline.write_text(json.dumps(entries))
    done = pytest_in(tmp_path, "claims.toml", "-q", "--imubench-against", "baseline.json")
    assert done.returncode == 1
    assert "2 times the baseline's, the median of" in done.stdout
