"""The public names of the library and what a caller relies on of each: `python -m tests.public_names` writes them down.

Of a function: its parameters in their order, which of them have which default. Of a class: the same of what makes one,
its methods and properties.
"""

import inspect
from enum import Enum
from pathlib import Path

import imubench

WRITTEN = Path(__file__).with_suffix(".txt")
ON_PURPOSE = (
    "the public names have changed. If that was meant: write it into CHANGELOG.md, raise the version as "
    "CONTRIBUTING.md says (what goes or changes its parameters is deprecated first), update docs/library.md, and run "
    "`python -m tests.public_names`"
)


def lines() -> list[str]:
    """Return a line for each public name and each method of a public class."""
    found = []
    for name in sorted(imubench.__all__):
        value = getattr(imubench, name)
        found.append(f"{name}{parameters(value)}")
        if inspect.isclass(value):
            members = {key: inspect.getattr_static(value, key) for key in dir(value) if not key.startswith("_")}
            for key, member in members.items():
                if inspect.isfunction(member):
                    found.append(f"{name}.{key}{parameters(member)}")
                elif isinstance(member, property):
                    found.append(f"{name}.{key}")
    return found


def parameters(value: object) -> str:
    """Return the parameters of a function as they are called: names, kinds and defaults, without types."""
    if inspect.isclass(value) and issubclass(value, Exception | Enum):
        return ""
    told = inspect.signature(value)  # type: ignore[arg-type]
    bare = [
        p.replace(annotation=inspect.Parameter.empty, default=p.empty if p.default is p.empty else Default(p.default))
        for p in told.parameters.values()
    ]
    return str(told.replace(parameters=bare, return_annotation=inspect.Signature.empty))


class Default:
    """A default as a caller sees it: plain values as they are, others by their kind."""

    def __init__(self, value: object) -> None:
        self.value = value

    def __repr__(self) -> str:
        plain = self.value is None or isinstance(self.value, bool | int | float | str | tuple)
        return repr(self.value) if plain else "..."


if __name__ == "__main__":
    WRITTEN.write_text("\n".join(lines()) + "\n", encoding="utf-8")
