"""Where a command's words go, and what it may write, is somebody else's choice: no result is lost by it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from imubench.proof.case import make_case
from tests.faults.content import content
from tests.test_main import one_line

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="redirects as a POSIX shell does")
RESULT = {".imubench.json", "list.json"}


def shell(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a line of the shell in which `imubench` is ours."""
    script = f'set -o pipefail; imubench() {{ "{sys.executable}" -m imubench "$@"; }}; {line}'
    return subprocess.run(
        ["bash", "-c", script],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, **environment},
    )


@pytest.fixture(scope="module")
def listed(tmp_path_factory):
    """What `list --out` writes, undisturbed."""
    folder = tmp_path_factory.mktemp("listed")
    assert shell("imubench list rigs --out out", folder).returncode == 0
    found = content(folder / "out")
    assert set(found) == RESULT
    return found


@pytest.mark.long
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs Linux' always full device")
def test_an_output_stream_on_a_full_disk_is_one_line_and_the_result_is_there(listed, tmp_path):
    done = shell("imubench list rigs --out out > /dev/full", tmp_path)
    assert done.returncode == 2
    line = "imubench: standard output: expected a place that can be written, got: No space left on device"
    assert one_line(done.stderr) == line
    assert content(tmp_path / "out") == listed


@pytest.mark.long
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs Linux' always full device")
def test_an_error_that_cannot_be_said_keeps_its_exit_code(tmp_path):
    assert shell("imubench list rgs --out out 2> /dev/full", tmp_path).returncode == 2
    assert shell("imubench list rgs --out out > /dev/full 2>&1", tmp_path).returncode == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("reader", ("head -1", "true", "head -c 1", "sh -c 'exec <&-'"))
def test_a_reader_that_goes_away_ends_nothing(reader, listed, tmp_path):
    done = shell(f"imubench list rigs --out out | {reader}", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert content(tmp_path / "out") == listed


def test_a_reader_of_errors_that_goes_away_leaves_the_exit_code(tmp_path):
    assert shell("imubench list rgs 2>&1 >/dev/null | true", tmp_path).returncode == 2


@pytest.mark.parametrize("closed", ("<&-", ">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-", "<&- 2>&-"))
def test_streams_that_are_closed_are_not_mistaken_for_files(closed, listed, tmp_path):
    """A file that is opened where a closed stream was would take what is said."""
    done = shell(f"imubench list rigs --out out {closed}", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert content(tmp_path / "out") == listed


@pytest.mark.long
def test_workers_of_a_command_without_streams_do_their_work(tmp_path):
    (tmp_path / "spec.toml").write_text("name = 'small'\nseconds = 2\n[[rig]]\nfamily = 'hinge'\n")
    for name, closed in (("a", ""), ("b", "<&- >&- 2>&-")):
        line = f"imubench generate spec.toml --count 2 --seed 1 --workers 1 --out {name} {closed}"
        assert shell(line, tmp_path).returncode == 0
    assert content(tmp_path / "a") == content(tmp_path / "b")


@pytest.mark.long
@pytest.mark.parametrize(
    "environment", ({"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}, {"PYTHONIOENCODING": "ascii"})
)
def test_what_a_terminal_cannot_show_is_shown_another_way(environment, tmp_path):
    """A recording's name in Greek, a folder's in German, and an error about either."""
    make_case(tmp_path / "Prüfung", "hinge", [], 5, seconds=2.0, name="γόνατο")
    done = shell("imubench estimate seel2012 Prüfung --out Lösung", tmp_path, **environment)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.isascii()
    assert (tmp_path / "Lösung" / "estimate.json").is_file()
    done = shell("imubench estimate seel2012 Übung --out Lösung", tmp_path, **environment)
    assert done.returncode == 2
    assert one_line(done.stderr).isascii()


@pytest.mark.long
@pytest.mark.parametrize(
    "line",
    (
        "imubench run hinge-hand --out out",
        "imubench convert csv table.csv --option rig=free --out out",
        "imubench generate spec.toml --count 2 --seed 1 --workers 1 --out out",
    ),
)
def test_a_limit_on_the_size_of_files_is_one_line(line, tmp_path):
    """The system's signal for it would end the process."""
    (tmp_path / "spec.toml").write_text("name = 'small'\nseconds = 20\n[[rig]]\nfamily = 'hinge'\n")
    rows = "".join(f"{n / 100},0.1,0.2,0.3,0,0,9.81\n" for n in range(2000))
    (tmp_path / "table.csv").write_text(f"time,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z\n{rows}")
    done = shell(f"ulimit -f 40; {line}", tmp_path)  # kB, less than each of their tables
    assert done.returncode == 2
    assert one_line(done.stderr).endswith("expected a place that can be written, got: File too large")
    assert {p.name for p in tmp_path.iterdir()} - {"out"} == {"spec.toml", "table.csv"}
    if (tmp_path / "out").exists():  # what is finished of a dataset is kept
        assert not list(tmp_path.rglob("*.partial.*"))
        assert not (tmp_path / "out" / "manifest.json").exists()
