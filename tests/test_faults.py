"""Each command's writes fail, are interrupted, or meet a signal: one line, nothing half-written, and it goes on.

A full disk (from one call on), ENOSPC and EIO once and for good, EINTR, a write cut short, SIGTERM, SIGINT and SIGKILL
at a call that writes, makes, renames or flushes something, in the C library, so that Arrow's, NumPy's and Rerun's are
met as well. Here a sample; `python -m benchmarks faults` does them all.
"""

import pytest

from tests.faults.commands import COMMANDS
from tests.faults.injection import FAULTS, Injections, why_not

pytestmark = pytest.mark.skipif(bool(why_not()), reason=why_not())
SHORT = {"list": (), "convert csv": (), "generate": pytest.mark.long}
"""Commands whose sample takes seconds, and their marks; the others are marked slow."""


@pytest.fixture(scope="module")
def injections(tmp_path_factory):
    found = Injections(tmp_path_factory.mktemp("faults").resolve())
    yield found
    found.warm.close()


@pytest.mark.long
@pytest.mark.parametrize("name", [pytest.param(name, marks=SHORT.get(name, pytest.mark.slow)) for name in COMMANDS])
def test_a_fault_at_a_write_is_one_line_leaves_nothing_and_the_command_goes_on(name, injections):
    one = injections.into(name)
    done = [one.trial(at, fault) for at, fault in one.sample(len(FAULTS) if name in SHORT else 3 * len(FAULTS))]
    assert {d.fault for d in done} == {fault.name for fault in FAULTS}
    assert [d for d in done if d.wrong] == []
    assert {2, 143, 130, -9} <= {d.code for d in done}  # or nothing has failed, and nothing was tested
