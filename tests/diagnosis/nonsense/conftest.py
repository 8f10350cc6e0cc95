"""Recordings by the generator of the proof, for all tests of this folder."""

import pytest

from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.recording import Recording
from tests.diagnosis.nonsense.recordings import RIGS


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """Return a function that makes a recording of 16 s at 50 Hz by the generator of the proof, once."""
    folder, known = tmp_path_factory.mktemp("made"), {}

    def make(rig: str, seed: int, effects=()) -> Recording:
        key = (rig, seed, str(effects))
        if key not in known:
            target = folder / str(len(known))
            make_case(target, effects=effects, seed=seed, strength="strong", seconds=16.0, rate=50.0, **RIGS[rig])
            known[key] = read(target)[0]
        return known[key]

    return make
