"""`imubench explain`: an effect, a figure or a word in plain words."""

from dataclasses import asdict
from pathlib import Path

from imubench.answers import write_json
from imubench.atomic import atomic_directory
from imubench.explain import explained
from imubench.terminal import Terminal


def run(name: str, out: Path | None, console: Terminal) -> None:
    """Print what a name means, and write it to explain.json where there is a folder for it.

    Raises:
        InputError: for a name that is none.
    """
    found = explained(name)
    if out is not None:
        with atomic_directory(out) as folder:
            write_json(folder / "explain.json", asdict(found) | {"details": list(found.details)})
    console.say(found.name, "bold", f" ({found.kind}): {found.text}")
    for line in found.details:
        console.say(f"  {line}")
