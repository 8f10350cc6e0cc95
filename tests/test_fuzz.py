"""The fuzzer itself: every reader is in it, its inputs repeat, and it sees each kind of failure."""

import ast
import hashlib
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from fuzz import inputs
from fuzz.__main__ import main
from fuzz.minimise import minimised
from fuzz.pool import Pool
from fuzz.readers import READERS
from fuzz.scratch import notes_reads
from fuzz.verdict import of_command, refused
from fuzz.worker import Limits, Task
from tests.defects import picky

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-dir"]
TIGHT = Limits(seconds=2.0, memory=500_000_000)


@pytest.fixture(scope="module")
def pool():
    with Pool(1) as workers:
        yield workers


@pytest.fixture(scope="module")
def defective():
    with Pool(1, TIGHT, "tests.defects") as workers:
        yield workers


# The readers


@pytest.mark.parametrize("command", [False, True], ids=["reader", "command"])
@pytest.mark.parametrize("name", READERS)
def test_the_valid_input_of_every_reader_is_accepted(name, command, pool):
    reader = READERS[name]
    if command and reader.words is None:
        pytest.skip("no command that ends in seconds reads it alone")
    outcome = pool.one(Task(name, content=reader.files()[reader.target], command=command))
    assert outcome.verdict == ("refused" if reader.refuses else "accepted"), outcome


READING = {
    "read_bytes", "read_text", "loads", "load", "read_csv", "read_table", "ParquetFile", "loadmat", "whosmat",
    "genfromtxt", "loadtxt", "from_file", "from_string", "from_xml_path", "from_xml_string", "fromfile", "memmap",
    "fromstring", "frombuffer", "ParserCreate",
}  # fmt: skip
"""Calls that read a file or parse what one holds, by the last part of their name."""

MODULES_THAT_READ = {"csv": {"reader", "DictReader"}, "h5py": {"File"}, "os": {"read", "open"}, "io": {"open"}}
OWN = {
    "imubench.models:_ours": "the package's own rigs",
    "imubench.models.tree:rig_spec": "the package's own rigs",
    "imubench.sim.profiles:<module>": "the package's own profiles",
    "imubench.scenarios.olsson2020.plan:<module>": "the package's own sequences",
    "imubench.scenarios.olsson2020.plan:parse": "the package's own sequences",
    "imubench.concealed:opened": "the package's own truth about the demo's recording",
    "imubench.concealed:show": "the package's own recording of the demo",
    "imubench.estimators.centre_ekf:stored": "the package's own covariances",
    "imubench.diagnosis.report.page:page": "the package's own style sheet",
    "imubench.reproduce.report:page": "the package's own style sheet",
    "imubench.trials.report:page": "the package's own style sheet",
    "imubench.trials.figures:figures": "the package's own limits",
    "imubench.sweeps.page:page": "the package's own style sheets",
    "imubench.sweeps.run:_outcomes": "through `Store.load`, which a reader reaches",
    "imubench.plugin_versions:estimator_version": "Python's own import of an estimator from outside",
    "imubench.plugin_versions:module_version": "the estimator's own code, for its hash",
    "imubench.plugin_versions:_hash": "the estimator's own code, for its hash",
    "imubench.reproduce.parts:sources": "the package's own code, for its hash",
    "imubench.reproduce.parts:run_parts": "through `Store.load`, which a reader reaches",
    "imubench.trials.prove:_proved": "what `publish` and `publish_sealed` have just written or read",
    "imubench.trials.guard:watch": "opens a note for writing",
    "imubench.trials.blind:diagnosed": "what the diagnosis that was started printed, shown as text",
    "imubench.plugins:find_estimator": "a file of Python that its author has run: there is nothing to be refused in it",
    "imubench.plugins:__call__": "Python's own import of an estimator from outside",
    "imubench.plugins:_described": "Python's own import of an estimator from outside",
    "imubench.attempt:_unusable": "Python's own import of an estimator from outside",
    "imubench.atomic:_flush": "opens what was just written, to flush it",
    "imubench.terminal:_failed": "opens the null device",
    "imubench.main:_open_streams": "opens the null device",
    "imubench.diagnosis.problem.bspline:_weigh": "stamps in memory, as the key of a cache",
    "imubench.diagnosis.problem.rig_kinematics:_turning": "numbers in memory, as the key of a cache",
}
"""Functions that read nothing that somebody hands over, each with the reason."""


def of_inputs() -> set[str]:
    """Return the names of the functions by which the rest of the package reads."""
    trees = [ast.parse(p.read_text()) for p in (ROOT / "imubench" / "inputs").glob("*.py")]
    names = {n.name for tree in trees for n in tree.body if isinstance(n, ast.FunctionDef)}
    return {name for name in names if name.startswith(("load", "read", "parse", "opened", "compiled"))}


def reading_functions() -> set[str]:
    """Return `module:function` of every function of the package that reads."""
    found, named = set(), READING | of_inputs()
    for package, folder in PACKAGES.items():
        for source in sorted((ROOT / folder).glob("*.py")):
            module = package if source.stem == "__init__" else f"{package}.{source.stem}"
            for function, call in calls(ast.parse(source.read_text())):
                if reads(call, named):
                    found.add(f"{module}:{function}")
    return found


def calls(tree: ast.AST, function: str = "<module>"):
    """Yield the name of the function around each call, and the call."""
    for node in ast.iter_child_nodes(tree):
        inner = node.name if isinstance(node, ast.FunctionDef) else function
        if isinstance(node, ast.Call):
            yield function, node
        yield from calls(node, inner)


def reads(call: ast.Call, named: set[str]) -> bool:
    """Say whether a call reads, or parses what was read."""
    name = call.func
    if isinstance(name, ast.Name):
        return name.id in named | {"open"} and not writes(call)
    if not isinstance(name, ast.Attribute):
        return False
    if isinstance(name.value, ast.Name) and name.value.id in MODULES_THAT_READ:
        return name.attr in MODULES_THAT_READ[name.value.id]
    return name.attr in named or (name.attr == "open" and not writes(call))


def writes(call: ast.Call) -> bool:
    """Say whether a file is opened for writing."""
    modes = [a.value for a in (*call.args, *(k.value for k in call.keywords)) if isinstance(a, ast.Constant)]
    return any(isinstance(m, str) and set(m) <= set("rwabtx+") and set(m) & set("wax") for m in modes)


@pytest.mark.long
def test_every_function_that_reads_is_reached_by_a_reader():
    """Run the valid input of each reader and a few broken ones, and look which functions of the package they enter."""
    code = "from tests.reached import reached; print('\\n'.join(sorted(reached())))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    reached, reading = set(done.stdout.split()), reading_functions()
    assert not sorted(reading - reached - OWN.keys()), "functions that read and that no reader of the fuzzer reaches"
    assert not sorted(OWN.keys() - reading), "functions that read no longer"


# Inputs


def fingerprint() -> str:
    """Return the hash of some inputs of every reader."""
    found = hashlib.sha256()
    for reader in READERS.values():
        for index in (*range(12), 1_000):
            found.update(hashlib.sha256(inputs.content(reader, 5, index)).digest())
    return found.hexdigest()


@pytest.mark.long
def test_inputs_follow_from_seed_reader_and_number_alone():
    """In another process, whose hashes of texts and whose clock are others, the same bytes come."""
    code = "from tests.test_fuzz import fingerprint; print(fingerprint())"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.stdout.split() == [fingerprint()], done.stderr


@pytest.mark.parametrize("name", READERS)
def test_inputs_of_a_reader_differ_and_are_broken(name):
    reader = READERS[name]
    made = {inputs.content(reader, 1, index) for index in range(30)}
    assert len(made) > 20  # a few small files are broken in the same way twice
    assert len(made - {reader.files()[reader.target]}) >= len(made) - 1


# Verdicts


@pytest.mark.parametrize(
    ("line", "verdict", "what"),
    [
        ("imu1.csv: expected a number", "refused", ""),
        ("a\nb", "failed", "lines"),
        ("", "failed", "lines"),
        ("x" * 301, "failed", "long"),
        ("x" * 300, "refused", ""),
        ("red \x1b[31m", "failed", "control"),
        ("lone \ud800", "failed", "control"),
        ("malloc of size 4294967296 failed", "failed", "memory"),
    ],
)
def test_a_refusal_is_one_line(line, verdict, what):
    outcome = refused(line)
    assert (outcome.verdict, outcome.what.partition(":")[0]) == (verdict, what)


@pytest.mark.parametrize(
    ("code", "output", "errors", "verdict", "what"),
    [
        (0, "done\n", "", "accepted", ""),
        (1, "one claim fails\n", "", "accepted", ""),
        (2, "", "imubench: a.toml: expected TOML\n", "refused", ""),
        (2, "", "warning\nimubench: a.toml: expected TOML\n", "failed", "command: lines"),
        (2, "", "", "failed", "command: lines"),
        (70, "", "imubench: an error of ours\n", "failed", "command: trace: ?, elsewhere"),
        (139, "", "", "failed", "command: exit code 139"),
        (0, "name \x1b[31m\n", "", "failed", "command: control"),
        (1, "", "Traceback (most recent call last):\n", "failed", "command: a trace"),
    ],
)
def test_what_a_command_prints_is_judged(code, output, errors, verdict, what):
    outcome = of_command(code, output, errors)
    assert outcome.verdict == verdict and outcome.what.startswith(what), outcome


@pytest.mark.parametrize(
    ("defect", "what"),
    [
        ("good", ""),
        ("raising", "trace: KeyError, tests/defects.py:raising"),
        ("growing", "memory: over the limit"),
        ("peaking", "memory: over the limit"),
        ("computing", "hang: it computes beyond the limit"),
        ("waiting", "hang: it waits beyond the limit"),
        ("crashing", "crash: exit code -11"),
        ("reading", "read: a file outside the input's folder"),
        ("reading_past_python", "read: a file outside the input's folder"),
        ("writing", "wrote: a file outside the input's folder"),
        ("straying", "wrote: a file outside the input's folder"),
        ("removing", "wrote: a file outside the input's folder"),
        ("changing", "changed: the input"),
        ("leaving", "left: a file in the working folder"),
        ("good", ""),  # the worker is whole again
    ],
)
def test_every_kind_of_failure_is_seen(defect, what, defective, tmp_path):
    if defect == "reading_past_python" and not notes_reads(tmp_path):
        pytest.skip("this file system does not note when a file is read")
    outcome = defective.one(Task(defect, content=b"broken"))
    assert (outcome.verdict, outcome.what) == ("failed" if what else "accepted", what), outcome


def test_a_failing_input_is_made_small(defective):
    task = Task("picky", index=1)
    content = b"head\n" * 200 + b"1,2,3\n" + b"filler\n" * 300 + b"buzz and more\n" + b"tail\n" * 100
    small = minimised(defective, task, content, f"trace: ValueError, tests/defects.py:{picky.__name__}")
    assert small == b",\nzz"  # nothing of it can be left out


# The command


@pytest.mark.long
def test_a_run_counts_every_reader_and_ends_well(capsys, tmp_path):
    assert main(["--each", "2", "--workers", "1", "--corpus", str(tmp_path), "--reader", "sequences-toml"]) == 0
    out = capsys.readouterr().out
    assert "| sequences-toml | 2 |" in out and "2 inputs of 1 readers, seed 0" in out
    assert not list(tmp_path.iterdir())


def test_an_unknown_reader_names_the_known_ones(capsys):
    assert main(["--reader", "watch"]) == 2
    assert "unknown reader 'watch'; known: recording-toml, imu2-csv" in capsys.readouterr().err
