"""What came of an input: accepted, refused in one line, or failed; and how that is told from an exception or output."""

import re
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from imubench.errors import InputError

LONGEST = 300  # characters of a refusal
UNFORESEEN = 70  # exit code of an error that is not the user's
FRAME = re.compile(r'File "(?P<file>[^"]+)", line \d+, in (?P<name>\S+)')
ROOT = Path(__file__).resolve().parent.parent
ALLOCATED = ("malloc of size", "realloc of size", "out of memory", "Cannot allocate memory", "Unable to allocate")
"""What allocators say when they give up: a reader that passes this on has asked for memory before it looked."""

Verdict = Literal["accepted", "refused", "failed"]


@dataclass(frozen=True)
class Outcome:
    """What came of one input."""

    verdict: Verdict
    what: str = ""  # of a failure: its kind and place, the same for inputs that fail alike
    said: str = ""  # the refusal, or the last lines of a trace
    seconds: float = 0.0  # of processor time
    megabytes: float = 0.0  # at most, above what the process had


def refused(line: str) -> Outcome:
    """Return the outcome of a refusal: one line of at most 300 printable characters, or else a failure."""
    if len(line.splitlines()) != 1:
        return Outcome("failed", f"lines: a refusal of {len(line.splitlines())} lines", line[:1_000])
    if len(line) > LONGEST:
        return Outcome("failed", "long: a refusal of over 300 characters", line[:1_000])
    if not line.isprintable():
        return Outcome("failed", "control: a refusal with control characters", repr(line)[:1_000])
    if any(word in line for word in ALLOCATED):
        return Outcome("failed", "memory: a refusal by the allocator", line)
    return Outcome("refused", said=line)


def of_exception(error: BaseException) -> Outcome:
    """Return the outcome of an exception that left the reader."""
    if isinstance(error, InputError):
        found = refused(str(error))
        if found.verdict == "failed":
            return Outcome("failed", f"{found.what}, {place(error)}", found.said)
        return found
    shown = "".join(traceback.format_exception(error, limit=-6))[-3_000:]
    return Outcome("failed", f"trace: {type(error).__name__}, {place(error)}", shown)


def place(error: BaseException) -> str:
    """Return `file:function` of the innermost frame of the package."""
    found = "elsewhere"
    for frame, _ in traceback.walk_tb(error.__traceback__):
        path = Path(frame.f_code.co_filename)
        if (
            path.is_relative_to(ROOT)
            and "site-packages" not in path.parts
            and path.relative_to(ROOT).parts[0] != "fuzz"
        ):
            found = f"{path.relative_to(ROOT).as_posix()}:{frame.f_code.co_name}"
    return found


def of_command(code: object, output: str, errors: str, trace: str = "") -> Outcome:
    """Return the outcome of a whole command from its exit code, what it printed and the trace that it saved."""
    if "Traceback" in errors:
        return Outcome("failed", "command: a trace is printed", errors[-3_000:])
    if code == 2:
        line = errors.removesuffix("\n").removeprefix("imubench: ")
        found = refused(line)
        return found if found.verdict == "refused" else Outcome("failed", f"command: {found.what}", found.said)
    if code == UNFORESEEN:
        frames = [
            m for m in FRAME.finditer(trace) if m["file"].startswith(str(ROOT)) and "site-packages" not in m["file"]
        ]
        at = f"{Path(frames[-1]['file']).relative_to(ROOT).as_posix()}:{frames[-1]['name']}" if frames else "elsewhere"
        kind = (trace.strip().splitlines() or ["?"])[-1].partition(":")[0]
        return Outcome("failed", f"command: trace: {kind}, {at}", (errors + trace)[-3_000:])
    if code not in (0, 1):
        return Outcome("failed", f"command: exit code {code}", errors[-3_000:])
    odd = next((c for c in output + errors if not c.isprintable() and c not in "\n\t"), None)
    if odd is not None:
        return Outcome("failed", f"command: control character {odd!r} printed", repr(output + errors)[-1_000:])
    return Outcome("accepted")
