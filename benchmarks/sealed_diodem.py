"""Seal the four DIODEM recordings whose mounts are documented: IMUs screwed on, and IMUs on foam, beside two joints.

    python -m benchmarks.sealed_diodem DIR [START]
    imubench prove --real DIR --seconds 25 --workers 1

Needs IMUBENCH_DATA. Recordings start at START seconds. All declare the loose mount, so that no header tells the foam.
The documentation says no more of a screwed-on IMU than that; what real IMUs and printed joints have anyway (offsets,
a few tenths of a degree of play, noise above that of rest) is neither asked nor held against an answer. A mount that
gives is not among it.
"""

import json
import os
import sys
from dataclasses import replace
from pathlib import Path

from imubench import format1
from imubench.convert import CONVERTERS
from imubench.diagnosis.solve.subset import cut
from imubench.trials.sealed import seal

IMUS = ("imu1", "imu2")
LOOSE = 0.15  # rad
ANYWAY = (
    *(
        {"effect": f"{kind}_{what}", "at": at}
        for kind in ("gyro", "accel")
        for what in ("bias", "noise")
        for at in IMUS
    ),
    {"effect": "joint_play", "at": "joint"},
)
FOAM = [[{"effect": "rocking_mount", "at": at}, {"effect": "soft_mount", "at": at}] for at in IMUS]
DOCUMENTED = {"rigid": ("IMUs screwed on", []), "nonrigid": ("foam under both IMUs", FOAM)}


def sealed_folder(source: Path, out: Path, start: float = 0.0) -> list[str]:
    """Write and seal the recordings of a DIODEM trial below the new folder `out` and return their commitments."""
    hashes, k = [], 0
    for segments in ("3-4", "4-5"):
        for mount, (words, effects) in DOCUMENTED.items():
            one = CONVERTERS["diodem"](source, segments=segments, imu=mount)[0]
            recording = cut(one.recording, start, float("inf"))
            loose = tuple(replace(i, mount_rotation_std=LOOSE) for i in recording.imus)
            name = f"case{(k := k + 1)}"
            format1.write_recording(replace(recording, imus=loose, name=name), out / name, one.reference)
            truth = {"documented": f"joint {segments}: {words}", "effects": effects, "may": list(ANYWAY)}
            written = out / f"{name}.truth.json"
            written.write_text(json.dumps(truth, indent=1), encoding="utf-8")
            hashes.append(seal(written))
    return hashes


if __name__ == "__main__":
    folder, *begin = sys.argv[1:]
    data = Path(os.environ["IMUBENCH_DATA"]) / "diodem" / "trial1"
    print("\n".join(sealed_folder(data, Path(folder), float(begin[0]) if begin else 0.0)))
