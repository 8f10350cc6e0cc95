"""The door of the command line: whatever happens behind it ends in one line and the right exit code.

Little is imported here, so that Ctrl-C is handled from the first moment on.
"""

import os
import sys

from imubench import signals

BAD_INPUT, UNFORESEEN = 2, 70
KEPT = "nothing half-written is left"


def main() -> None:
    """Run the command line and exit: 0 done, 1 a limit or claim failed, 2 bad input, 70 an error of ours, 130, 143."""
    code, line = UNFORESEEN, ""
    try:
        signals.handle()
        _open_streams()
        code = _run()
        sys.stdout.flush()
        signals.ignore()
    except BaseException as error:
        signals.ignore()
        code, line = _ended_by(error)
    stopped = signals.came()
    if stopped is not None:  # whatever a library made of it
        code = stopped
        line = f"{'interrupted' if code == 130 else 'terminated'}; {signals.promised() or KEPT}"
    _undo()
    if line:
        code = _say(line, code)
    sys.exit(code)


def _open_streams() -> None:
    """Fill the places of standard streams that were closed, or the next file that is opened would take their place."""
    while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(handle, True)  # the processes that we start need them too
    os.close(handle)


def _run() -> int:
    import warnings

    if not sys.warnoptions:
        warnings.simplefilter("ignore")  # what a user must know is said in words
    os.environ.setdefault(
        "MUJOCO_GL", "disable"
    )  # nothing is rendered, and to find a window's library starts a process
    os.environ.setdefault("RUST_LOG", "error")  # so is what Rerun has to say; it reads this when it is imported
    from imubench.terminal import guard_streams

    guard_streams()
    from imubench.cli import app

    if len(sys.argv) == 1:
        sys.argv.append("--help")
    return int(app(prog_name="imubench", standalone_mode=False) or 0)


def _ended_by(error: BaseException) -> tuple[int, str]:
    """Return the exit code that goes with what ended the command, and the line to say."""
    if isinstance(error, KeyboardInterrupt):  # before the signals were handled
        return 130, f"interrupted; {KEPT}"
    if signals.came() is not None:
        return UNFORESEEN, ""
    try:
        from imubench.errors import InputError, first_line, printable, shortened

        if isinstance(error, SystemExit):
            return error.code if isinstance(error.code, int) else int(error.code is not None), ""
        if isinstance(error, InputError):
            return BAD_INPUT, str(error)
        if hasattr(error, "format_message"):  # the command line's own parser
            context = getattr(error, "ctx", None)
            path = context.command_path if context is not None else "imubench"
            message = printable(" ".join(error.format_message().split()))
            return BAD_INPUT, shortened(f"{message.rstrip('.')}; see {path} --help", 300)
        kept = _save_trace(error)
        what = shortened(printable(f"{type(error).__name__}: {first_line(error)}"), 150)
        return UNFORESEEN, f"an error of ours, {what}; {kept}"
    except Exception:
        return UNFORESEEN, ""


def _undo() -> None:
    """Undo what a context could not, see `leftovers`; without that module nothing was done."""
    leftovers = sys.modules.get("imubench.leftovers")
    if leftovers is not None:
        leftovers.undo_all()


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
    import tempfile
    import time
    import traceback
    from pathlib import Path

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
