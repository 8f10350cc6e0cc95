"""The door of the command line: one line and the right exit code, whatever happens behind it."""

import re
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from tests.command import here

LONGEST = len("imubench: ") + 300


def one_line(text: str) -> str:
    """Return the only line of a text, which can be shown and is not long."""
    (line,) = text.splitlines()
    assert line.startswith("imubench: ")
    assert line.isprintable()
    assert len(line) <= LONGEST
    return line


@pytest.fixture
def broken(monkeypatch):
    """Return a function that has `imubench list` end in an error."""

    def breaks(error: BaseException) -> None:
        def known() -> None:
            raise error

        monkeypatch.setattr("imubench.listing.known", known)

    return breaks


def test_an_unforeseen_error_is_one_line_and_its_trace_lies_where_it_says(broken, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    broken(RuntimeError("of \x1b[31m ours\nand more"))
    done = here("list", "--out", tmp_path / "out")
    assert done.code == 70
    line = one_line(done.err)
    assert r"an error of ours, RuntimeError: of \x1b[31m ours; please report it with its trace: " in line
    trace = Path(line.rpartition(" ")[2])
    assert trace.parent == tmp_path
    text = trace.read_text()
    assert "Traceback (most recent call last)" in text
    assert "and more" in text
    assert re.match(r"imubench \d+\.\d+\.\d+, Python 3", text)
    assert [p.name for p in tmp_path.iterdir()] == [trace.name]


def test_an_error_whose_trace_cannot_be_saved_is_one_line(broken, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    broken(ArithmeticError("x" * 1000))
    done = here("list")
    assert done.code == 70
    assert one_line(done.err).endswith("its trace could not be saved: No such file or directory")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["lists"], "No such command 'lists'"),
        (["run"], "missing argument 'scenario'"),
        (["run", "hinge-hand", "--sed", "1"], "No such option: --sed"),
        (["run", "hinge-hand", "--seed", "one"], "invalid value for '--seed': "),
        (["run", "hinge-hand", "--seed", "-1"], "invalid value for '--seed': "),
        (["run", "hinge-\x1b[31mhand"], r"unknown scenario 'hinge-\x1b[31mhand'"),
        (["convert", "csv", "x.csv"], "Missing option '--out'"),
        (["convert", "csv", "none.csv", "--out", "o", "--option", "rig"], "--option: expected key=value, got 'rig'"),
    ],
)
def test_what_was_typed_wrong_is_one_line(words, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = here(*words)
    assert (done.code, done.out) == (2, "")
    assert said.lower() in one_line(done.err).lower()  # some of it are the words of the parser's own version
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("words", [[], ["--help"], ["run", "--help"], ["--version"]])
def test_help_is_no_error(words):
    done = here(*words)
    assert (done.code, done.err) == (0, "")
    assert done.out


SWALLOWED = {
    "in __del__": """
        class Busy:
            def __del__(self):
                os.kill(os.getpid(), NUMBER)
                time.sleep(0.3)
        Busy()
        """,
    "by an extension module": """
        try:
            os.kill(os.getpid(), NUMBER)
            time.sleep(0.3)
        except BaseException:
            raise ImportError("initialization failed") from None
        """,
    "by code that holds everything": """
        try:
            os.kill(os.getpid(), NUMBER)
            time.sleep(0.3)
        except BaseException:
            pass
        """,
    "in a callback from C": """
        import ctypes
        @ctypes.CFUNCTYPE(None)
        def called():
            os.kill(os.getpid(), NUMBER)
            time.sleep(0.3)
        called()
        """,
}


@pytest.mark.skipif(sys.platform == "win32", reason="sends signals")
@pytest.mark.parametrize("number", (signal.SIGTERM, signal.SIGINT))
@pytest.mark.parametrize("how", SWALLOWED)
def test_a_signal_that_is_dropped_ends_the_command_all_the_same(how, number, tmp_path):
    """Python drops what is raised in a deletion or in a callback from C; a library may make something else of it."""
    body = textwrap.dedent(SWALLOWED[how]).replace("NUMBER", str(int(number)))
    script = f"import os, time\ndef work():\n{textwrap.indent(body, '    ')}\n    time.sleep(60)\n"
    script += "import imubench.listing\nimubench.listing.known = work\n"
    script += "import sys, signal\nsignal.signal(signal.SIGINT, signal.SIG_DFL)\n"
    script += "from imubench.main import main\nsys.argv = ['imubench', 'list']\nmain()\n"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=50, cwd=tmp_path)
    assert done.returncode == 128 + number
    word = "terminated" if number == signal.SIGTERM else "interrupted"
    assert one_line(done.stderr) == f"imubench: {word}; nothing half-written is left"


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="sends signals")
def test_a_signal_while_a_context_is_left_leaves_nothing(tmp_path):
    """The signal comes when `undone` is about to undo: the door undoes it then."""
    script = (
        "import os, signal, sys\nfrom pathlib import Path\nimport imubench.atomic as atomic\nimport imubench.listing\n"
        "flush = atomic._flush_names\n"
        "def killed(folder):\n    os.kill(os.getpid(), signal.SIGTERM)\n    flush(folder)\n"
        "atomic._flush_names = killed\n"
        "remove = atomic._remove\ncalls = []\n"
        "def once(path):\n"
        "    calls.append(path)\n"
        "    if len(calls) == 1:\n        raise KeyboardInterrupt\n"
        "    remove(path)\n"
        "atomic._remove = once\n"
        "from imubench.main import main\nsys.argv = ['imubench', 'list', '--out', 'out']\nmain()\n"
    )
    for _ in range(2):  # the second time an older folder is to be removed
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=50, cwd=tmp_path)
        assert done.returncode == 143
        one_line(done.stderr)
        assert sorted(p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*")) == [
            "out",
            "out/.imubench.json",
            "out/list.json",
        ]


@pytest.mark.long
def test_a_command_starts_no_process_to_look_for_a_windows_library(tmp_path):
    """MuJoCo's import would start a Python for it; an interrupt that reached that one made it print a trace."""
    code = """
    import sys
    started = []
    sys.addaudithook(lambda event, args: started.append(args) if event == "subprocess.Popen" else None)
    sys.argv = ["imubench", "run", "hinge-hand", "--out", "out"]
    from imubench.main import main
    try:
        main()
    finally:
        print(len(started), "glfw" in sys.modules, file=sys.stderr)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stderr.splitlines() == ["0 False"]
