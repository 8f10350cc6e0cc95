"""Files beside an input that no reader may open: each is what a reader would accept, were it led there."""

from fuzz.seeds import Files, foreign, recordings
from imubench.models import mjcf


def files() -> Files:
    """Return a file of every kind that a reader takes."""
    return {
        "kept.csv": recordings.as_csv()["imu1.csv"],
        "kept.parquet": recordings.as_parquet()["imu1.parquet"],
        "kept.toml": recordings.as_csv()["recording.toml"],
        "kept.hdf5": foreign.broad()["trial.hdf5"],
        "kept.xml": mjcf("hinge").encode(),
        "kept.stl": b"\0" * 80 + (1).to_bytes(4, "little") + bytes(50),
        "kept.png": b"\x89PNG\r\n\x1a\n" + bytes(100),
    }
