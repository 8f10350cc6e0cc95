"""The one exception that means "what you gave me is wrong"."""


class InputError(ValueError):
    """Bad input: its message is one line that says what, where, expected and got.

    The command line turns it into exit code 2. Any other exception is a defect of ours.
    """


def first_line(error: Exception) -> str:
    """Return the first line of somebody else's error; the name of its kind where it says nothing."""
    return (str(error).splitlines() or [""])[0] or type(error).__name__


def unknown(kind: str, name: object, known: object) -> InputError:
    """Return the error for a name that is not in a list, with the list."""
    names = ", ".join(str(k) for k in known)  # type: ignore[attr-defined]
    return InputError(f"unknown {kind} '{name}'; known: {names}")
