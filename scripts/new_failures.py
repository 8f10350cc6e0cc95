"""Fail where a reproduction has news: `python scripts/new_failures.py CLAIMS.json ...`.

A claim that is known to fail says so in its claims.toml; one that fails without, or has passed its guard, is news.
"""

import json
import sys
from pathlib import Path


def news(file: Path) -> list[str]:
    """Return one line for each claim of a claims.json that should stop a build."""
    claims = json.loads(file.read_text(encoding="utf-8"))
    return [f"{file}: {claim['name']}: {claim['news']}" for claim in claims if claim["news"]]


def main(files: list[str]) -> int:
    """Print the news of all files, and return 1 if there is any."""
    if not files:
        print("expected one claims.json or more, got none", file=sys.stderr)
        return 2
    found = [line for file in files for line in news(Path(file))]
    print("\n".join(found) or "claims: nothing new")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
