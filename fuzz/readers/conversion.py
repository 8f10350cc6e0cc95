"""Sources of the converters, and the options that come with them on the command line."""

from collections.abc import Callable
from pathlib import Path

from fuzz.mutate import csv, hdf5, mat, options
from fuzz.reader import Reader
from fuzz.seeds import foreign
from imubench import format1
from imubench.commands.convert import options_of
from imubench.convert import CONVERTERS


def chosen(f: Path) -> list[str]:
    """Return the options of an input, `key=value` each."""
    file = f / "options.txt"
    if not file.exists():
        return []
    text = file.read_text(encoding="utf-8", errors="replace")  # a broken byte is none that a terminal hands over
    return text.replace("\0", "").split("\n")


def converted(form: str, source: str) -> Callable[[Path, Path], object]:
    """Return what converts a source and writes the recordings."""

    def convert(f: Path, o: Path) -> object:
        found = CONVERTERS[form](f / source, **options_of(chosen(f)))
        for one in found:
            target = o if len(found) == 1 else o / one.recording.name
            format1.write_recording(one.recording, target, one.reference)
        return found

    return convert


def words(form: str, source: str) -> Callable[[Path, Path], list[str]]:
    """Return the words that convert a source."""

    def convert(f: Path, o: Path) -> list[str]:
        given = [word for line in chosen(f) for word in ("--option", line)]
        return ["convert", form, str(f / source), "--out", str(o), *given]

    return convert


CSV = (converted("csv", "a.csv"), words("csv", "a.csv"))
DIODEM = (converted("diodem", "trial"), words("diodem", "trial"))
BROAD = (converted("broad", "trial.hdf5"), words("broad", "trial.hdf5"))
MULTIARM = (converted("multiarm", "pendulum.mat"), words("multiarm", "pendulum.mat"))
RIGID, OPTICAL, OPTIONS = "trial/imu_rigid.csv", "trial/omc.csv", "options.txt"
READERS = (
    Reader("convert-csv", "a.csv", foreign.csv, csv.mutate, *CSV),
    Reader("convert-csv-options", OPTIONS, foreign.csv, options.mutate, *CSV, leads_outside=True),
    Reader("convert-diodem-imu", RIGID, foreign.diodem, csv.mutate_diodem, *DIODEM),
    Reader("convert-diodem-optical", OPTICAL, foreign.diodem, csv.mutate_diodem, *DIODEM),
    Reader("convert-diodem-options", OPTIONS, foreign.diodem, options.mutate, *DIODEM),
    Reader("convert-broad", "trial.hdf5", foreign.broad, hdf5.mutate, *BROAD),
    Reader("convert-multiarm", "pendulum.mat", foreign.multiarm, mat.mutate, *MULTIARM),
    Reader("convert-multiarm-options", OPTIONS, foreign.multiarm, options.mutate, *MULTIARM),
)
