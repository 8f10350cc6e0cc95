"""Hinge axes of one recording, in a process of its own: python -m benchmarks.real.axes RECORDING DIAGNOSIS OUT

DIAGNOSIS is the folder of `imubench diagnose`, taken out first as `imubench estimate --with` does; `-`: none.
"""

import sys
import tempfile
from pathlib import Path
from typing import Any

from imubench.answers import write_json
from imubench.atomic import atomic_file
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.format1 import read
from imubench.recording import Recording
from imubench.run import estimate, estimate_on_disk

ESTIMATORS = ("olsson2020", "seel2012", "olsson2020-banded")
RAW = "-"


def axes(recording: Path, diagnosis: Path | None) -> dict[str, Any]:
    """Return what each estimator says of a recording, or why it says nothing; "refused": why nothing was taken out."""
    if diagnosis is None:
        return _each(read(recording)[0])
    with tempfile.TemporaryDirectory() as scratch:
        out = Path(scratch) / "out"
        try:
            estimate_on_disk(ESTIMATORS[0], recording, out, diagnosis=diagnosis)
        except InputError as error:
            return {"refused": str(error)}
        return _each(read(out / "corrected")[0])


def _each(recording: Recording) -> dict[str, Any]:
    return {name: _said(name, recording) for name in ESTIMATORS}


def _said(name: str, recording: Recording) -> dict[str, Any]:
    try:
        answer: Estimate = estimate(name, recording)
    except InputError as error:
        return {"status": f"refused: {error}"}
    return {"status": answer.status, "pairing": answer.pairing, "value": answer.value.tolist()}


if __name__ == "__main__":
    given, told, target = sys.argv[1:]
    with atomic_file(Path(target)) as partial:
        write_json(partial, axes(Path(given), None if told == RAW else Path(told)))
