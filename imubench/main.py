"""The door of the command line: whatever happens behind it ends in one line and the right exit code.

Little is imported here, so that Ctrl-C is handled from the first moment on.
"""

import os
import sys
import tempfile
import time
import warnings
from pathlib import Path

from imubench import signals

BAD_INPUT, UNFORESEEN = 2, 70
KEPT = "nothing half-written is left"


def main() -> None:
    """Run the command line and exit: 0 done, 1 a limit or claim failed, 2 bad input, 70 an error of ours, 130, 143."""
    code = UNFORESEEN
    try:
        signals.handle()
        code = _run()
        sys.stdout.flush()
        signals.ignore()
    except signals.Stopped as stopped:
        code = _say(f"{'interrupted' if stopped.code == 130 else 'terminated'}; {KEPT}", stopped.code)
    except KeyboardInterrupt:
        code = _say(f"interrupted; {KEPT}", 130)
    except BaseException as error:
        code = _ended_by(error)
    sys.exit(code)


def _run() -> int:
    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # what a user must know is said in words
    from imubench.terminal import guard_streams

    guard_streams()
    from imubench.cli import app

    if len(sys.argv) == 1:
        sys.argv.append("--help")
    return int(app(prog_name="imubench", standalone_mode=False) or 0)


def _ended_by(error: BaseException) -> int:
    """Say what ended the command and return its exit code."""
    try:
        from imubench.errors import InputError, first_line, printable, shortened

        if isinstance(error, SystemExit):
            return error.code if isinstance(error.code, int) else int(error.code is not None)
        if isinstance(error, InputError):
            return _say(str(error), BAD_INPUT)
        if hasattr(error, "format_message"):  # the command line's own parser
            context = getattr(error, "ctx", None)
            path = context.command_path if context is not None else "imubench"
            message = printable(" ".join(error.format_message().split()))
            return _say(shortened(f"{message.rstrip('.')}; see {path} --help", 300), BAD_INPUT)
        kept = _save_trace(error)
        what = shortened(printable(f"{type(error).__name__}: {first_line(error)}"), 150)
        return _say(f"an error of ours, {what}; {kept}", UNFORESEEN)
    except signals.STOPS:
        return 130
    except Exception:
        return UNFORESEEN


def _say(line: str, code: int) -> int:
    try:
        sys.stderr.write(f"imubench: {line}\n")
        sys.stderr.flush()
    except (OSError, ValueError):  # nobody reads it
        pass
    return code


def _save_trace(error: BaseException) -> str:
    """Keep the trace where temporary files are and return where, as a part of the line that is said."""
    import platform
    import traceback

    import imubench

    stamp = time.strftime("%Y%m%d-%H%M%S")
    path = Path(tempfile.gettempdir()) / f"imubench-trace-{stamp}-{os.getpid()}.txt"
    head = f"imubench {imubench.__version__}, Python {platform.python_version()}, {platform.platform()}\n{sys.argv}\n\n"
    try:
        path.write_text(head + "".join(traceback.format_exception(error)), encoding="utf-8", errors="backslashreplace")
    except OSError as failed:
        return f"its trace could not be saved: {failed.strerror}"
    return f"please report it with its trace: {path}"


if __name__ == "__main__":
    main()
