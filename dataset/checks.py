"""Are the values in a manifest or a receipt of the kind that we write?"""


def is_whole(value: object, least: int = 0) -> bool:
    """Return whether a JSON value is a whole number from `least` on."""
    return isinstance(value, int) and not isinstance(value, bool) and value >= least


def is_count(value: object) -> bool:
    """Return whether a JSON value counts something that is there."""
    return is_whole(value, 1)


def lasts(value: object) -> bool:
    """Return whether a JSON value is a number of seconds that a recording may last: a spec allows 1 s or more."""
    return isinstance(value, int | float) and not isinstance(value, bool) and value >= 1


def are_counts(value: object) -> bool:
    """Return whether a JSON value is an object of whole numbers from 0 on."""
    return isinstance(value, dict) and all(is_whole(n) for n in value.values())


def are_files(value: object) -> bool:
    """Return whether a JSON value is an object of files, each with `sha256` and `bytes`."""
    return isinstance(value, dict) and all(
        isinstance(entry, dict) and isinstance(entry.get("sha256"), str) and is_whole(entry.get("bytes"))
        for entry in value.values()
    )
