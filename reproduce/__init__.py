"""Papers that can be reproduced: every figure, every table, and every claim measured again.

A paper is a folder with a `PAPER` (see `paper`) and a claims.toml, and a line in `PAPERS`.
"""

from imubench.reproduce.arve import PAPER as ARVE
from imubench.reproduce.arve.beyond import PAPER as ARVE_BEYOND
from imubench.reproduce.olsson2020 import PAPER as OLSSON2020
from imubench.reproduce.olsson2020.beyond import PAPER as OLSSON2020_BEYOND
from imubench.reproduce.paper import Paper

PAPERS: dict[str, Paper] = {p.name: p for p in (OLSSON2020, OLSSON2020_BEYOND, ARVE, ARVE_BEYOND)}
"""All papers by name."""
