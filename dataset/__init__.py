"""Labelled synthetic recordings in bulk: a spec, a seed and a number say everything about each of them.

    from imubench.dataset import read
    stored = read("runs/hinges", 17)
    stored.recording, stored.truth, stored.effects

Data flows as everywhere: spec -> draw -> play -> Truth -> observe -> Recording, and then into Parquet.
"""

from imubench.dataset.drawing import draw
from imubench.dataset.playing import Made, make
from imubench.dataset.reading import Stored, read
from imubench.dataset.spec import Spec, load_spec, parse_spec

__all__ = ["Made", "Spec", "Stored", "draw", "load_spec", "make", "parse_spec", "read"]
