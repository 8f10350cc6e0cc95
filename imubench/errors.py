"""The one exception that means "what you gave me is wrong", and how text of strangers is shown."""

from difflib import get_close_matches

LONGEST_MESSAGE = 300
"""Characters of an error's line: what still can be read at a glance on a terminal of 100 columns."""
LONGEST_NAME = 60
"""Characters of a name that a message shows."""
CLOSE = 0.7
"""Share of letters in common (difflib) from which on a name is a slip of another: `piece` and `pieces` have 0.9."""


class InputError(ValueError):
    """Bad input: its message is one line that says what, where, expected and got.

    The line is cut to `LONGEST_MESSAGE` characters, and control characters in it are shown, whoever wrote them.
    The command line turns it into exit code 2. Any other exception is a defect of ours.
    """

    def __init__(self, message: object) -> None:
        super().__init__(shortened(printable(" ".join(str(message).split())), LONGEST_MESSAGE))


def printable(text: str) -> str:
    r"""Return text whose control characters, line ends and lone surrogates are shown as `\x1b`, `\n`, `\ud800`."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape", "surrogatepass").decode() for c in text)


def shortened(text: str, most: int) -> str:
    """Return text of at most so many characters; what is left out of the middle is marked by ` ... `."""
    if len(text) <= most:
        return text
    mark = " ... "
    end = (most - len(mark)) * 2 // 5  # what came stands at the end, what it is about at the beginning
    return text[: most - len(mark) - end] + mark + text[len(text) - end :]


def shown(value: object, most: int = 60) -> str:
    """Return a value of any size as a message shows it: its `repr`, printable and at most so many characters.

    Values that are nested too deeply, or whole numbers too long, to be written out are named by their kind.
    """
    try:
        text = repr(value)
    except (RecursionError, ValueError, MemoryError):
        text = f"a {type(value).__name__} too large to be shown"
    return shortened(printable(text), most)


def first_line(error: BaseException) -> str:
    """Return the first line of somebody else's error; the name of its kind where it says nothing."""
    return (str(error).splitlines() or [""])[0] or type(error).__name__


def unknown(kind: str, name: object, known: object) -> InputError:
    """Return the error for a name that is not in a list, with the list, and the one that it is like."""
    names = [str(k) for k in known]  # type: ignore[attr-defined]
    text = shortened(name if isinstance(name, str) else shown(name), LONGEST_NAME)
    like = closest(text, names)
    hint = "" if like is None else f"; did you mean '{like}'?"
    return InputError(f"unknown {kind} '{text}'; known: {', '.join(names)}{hint}")


def closest(name: str, known: list[str]) -> str | None:
    """Return the one of some names that a name is a slip of; None where it is like none of them."""
    by_case = {k.casefold(): k for k in known}
    found = get_close_matches(name.casefold(), by_case, n=1, cutoff=CLOSE)
    return by_case[found[0]] if found else None
