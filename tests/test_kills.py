"""Long commands killed at moments by chance, and two into one folder. `python -m benchmarks kills` does more."""

import os
import signal
import sys
import time

import pytest

from tests.faults.commands import COMMANDS, given
from tests.faults.content import content
from tests.faults.kills import SIGNALS, Kills, different, moments
from tests.test_main import one_line

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="finds processes in /proc")
LONG = ("run", "estimate", "convert csv", "diagnose", "reproduce", "generate, 2 workers", "export qmt", "prove",
    "sweep", "check, 2 workers",
)  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return given(tmp_path_factory.mktemp("kills").resolve() / "given")


@pytest.fixture(scope="module")
def undisturbed(made, tmp_path_factory):
    """Return a function that runs a command once undisturbed and returns what can kill it."""
    found: dict[str, Kills] = {}

    def kills(name: str) -> Kills:
        if name not in found:
            found[name] = Kills(COMMANDS[name], made, tmp_path_factory.mktemp("killed").resolve() / "home")
        return found[name]

    return kills


@pytest.mark.long
@pytest.mark.parametrize("number", SIGNALS, ids=lambda s: s.name)
@pytest.mark.parametrize("name", [n if n == "run" else pytest.param(n, marks=pytest.mark.slow) for n in LONG])
def test_a_command_that_is_killed_leaves_nothing_running_and_comes_to_the_same_bytes(name, number, undisturbed):
    kills = undisturbed(name)
    for i, moment in enumerate(moments(kills, 1 if name == "run" else 2, number)):
        done = kills.kill(number, moment, group=bool(i % 2))
        assert done.wrong == [], done


@pytest.mark.slow
@pytest.mark.parametrize("name", LONG)
def test_the_second_of_two_runs_into_one_folder_is_refused_and_the_first_is_untouched(name, undisturbed, tmp_path):
    """The first is stopped for a while as soon as it has the lock, so that the second surely comes meanwhile."""
    kills = undisturbed(name)
    work = tmp_path / "work"
    for folder in (work, tmp_path / "work-tmp"):
        folder.mkdir()
    first = kills.start(work)
    end = time.monotonic() + 60
    locks = (work / ".out.lock", work / "out" / ".generate" / "lock")
    while not any(lock.exists() and lock.read_text() for lock in locks):
        assert first.poll() is None and time.monotonic() < end
        time.sleep(0.005)
    os.killpg(first.pid, signal.SIGSTOP)
    try:
        second = kills.start(work)
        _, errors = second.communicate(timeout=60)
    finally:
        os.killpg(first.pid, signal.SIGCONT)
    assert second.returncode == 2
    assert one_line(errors.decode()).endswith(f"got one in use by process {first.pid}")
    _, errors = first.communicate(timeout=120)
    assert (first.returncode, errors) == (kills.code, b"")
    assert different(content(work), kills.whole) == []
