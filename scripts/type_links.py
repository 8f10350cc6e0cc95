"""Lay the packages of pyproject.toml out under .types/ as links, as the type checker expects them."""

import shutil
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINKS = ROOT / ".types"


def main() -> None:
    """Make .types/ anew."""
    mapping = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-dir"]
    shutil.rmtree(LINKS, ignore_errors=True)
    for package, folder in sorted(mapping.items()):
        target = LINKS / package.replace(".", "/")
        target.mkdir(parents=True, exist_ok=True)
        for source in sorted((ROOT / folder).glob("*.py")):
            (target / source.name).symlink_to(source)


if __name__ == "__main__":
    main()
