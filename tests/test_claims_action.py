"""The example of docs/your-claim.md in a throw-away repository: the workflow's steps, before and after a mistake."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

EXAMPLE = Path(__file__).resolve().parent.parent / "docs" / "examples" / "claims"
WORKFLOW = ".github/workflows/claims.yml"
SOON = "confidence = 0.95\npower = 0.95\n"  # fewer runs than the example's own, which take as long as all else
WORSE = ("both = paired(recording)", "both = paired(recording)\n    both = _first_part(both)")
FIRST_PART = """

def _first_part(both):
    from dataclasses import fields, replace

    rows = slice(len(both.time) * 4 // 5)
    return replace(both, **{f.name: getattr(both, f.name)[rows] for f in fields(both)})
"""


@pytest.fixture(scope="module")
def repository(tmp_path_factory) -> Path:
    """A repository with the estimator, its claims, the workflow and a baseline, all committed."""
    folder = tmp_path_factory.mktemp("theirs")
    (folder / WORKFLOW).parent.mkdir(parents=True)
    shutil.copy(EXAMPLE / "claims.yml", folder / WORKFLOW)
    shutil.copy(EXAMPLE / "mine.py", folder)
    (folder / "claims.toml").write_text(SOON + (EXAMPLE / "claims.toml").read_text())
    made = shell("imubench check claims.toml --save-baseline baseline.json --runs 50 --out first", folder)
    assert made.returncode == 0, made.stdout + made.stderr
    shutil.rmtree(folder / "first")
    for words in (("init", "-q"), ("add", "."), ("-c", "user.name=t", "-c", "user.email=t@t", "commit", "-qm", "all")):
        subprocess.run(["git", *words], cwd=folder, check=True)
    return folder


def shell(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a line as a workflow of GitHub does, with the imubench of this environment."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    words = ["bash", "--noprofile", "--norc", "-e", "-o", "pipefail", "-c", line]
    return subprocess.run(
        words, cwd=folder, env={**os.environ, "PATH": path, **environment}, capture_output=True, text=True, timeout=600
    )


def steps(folder: Path) -> list[str]:
    """Return the lines that the workflow runs, but for the installation: imubench is here already."""
    workflow = yaml.safe_load((folder / WORKFLOW).read_text())
    assert workflow[True] == ["push", "pull_request"]  # YAML 1.1 reads `on` as true
    (job,) = workflow["jobs"].values()
    lines = [step["run"] for step in job["steps"] if "run" in step]
    assert [line for line in lines if "pip install" in line] == ['python -m pip install "$IMUBENCH"']
    return [line for line in lines if "pip install" not in line]


def ran(folder: Path) -> tuple[int, str, str]:
    """Return the exit code of the workflow, what its steps print, and the summary that GitHub would show."""
    shown = folder.parent / f"{folder.name}-summary.md"
    shown.write_text("")
    printed = ""
    for line in steps(folder):
        done = shell(line, folder, GITHUB_STEP_SUMMARY=str(shown))
        printed += done.stdout + done.stderr
        if done.returncode:
            return done.returncode, printed, shown.read_text()
    return 0, printed, shown.read_text()


@pytest.mark.long
def test_the_workflow_passes_as_it_stands_and_fails_when_the_estimator_gets_worse(repository):
    code, printed, shown = ran(repository)
    assert code == 0, printed
    assert shown.startswith("## imubench check: all 4 claims hold\n")
    estimator = repository / "mine.py"
    right = estimator.read_text()
    estimator.write_text(right.replace(*WORSE) + FIRST_PART)  # far within two degrees, but 40 % worse than it was
    code, printed, shown = ran(repository)
    assert code == 1, printed
    assert "axis beside the baseline" in shown.splitlines()[0]
    entries = {e["name"]: e for e in json.loads((repository / "checked" / "claims.json").read_text())}
    assert entries["axis"]["verdict"] == "holds"
    assert entries["axis beside the baseline"]["verdict"] == "fails"
    estimator.write_text(right + "\n1 +\n")
    assert ran(repository)[0] == 2  # no estimator at all is bad input
