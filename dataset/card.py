"""The data card: what is in a dataset, its distributions as pictures, its limits and licence, in one HTML file."""

from array import array
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import IO, Any

import numpy as np

from imubench.dataset.pictures import histogram, shares
from imubench.dataset.rig_ranges import GYRATION
from imubench.dataset.spec import SPEC_FILE, Spec
from imubench.effects import EFFECTS
from imubench.errors import InputError, unknown
from imubench.inputs.json import parse_json
from imubench.inputs.parquet import opened_parquet
from imubench.models import is_rig
from imubench.models.tree import rig_tree

CARD = "card.html"
NAMES = ("family", "motion", "split", "imu1_profile")
NUMBERS = {  # column of the recordings -> title, unit; N stands for every IMU or segment
    "seconds": ("Length of a recording", "s"),
    "imuN_gyro_rms": ("Angular rate as read, rms of a recording", "rad/s"),
    "imuN_accel_rms": ("Specific force as read, rms of a recording", "m/s²"),
    "imuN_position": ("Sensor to the segment's origin", "m"),
    "imuN_gyro_bias": ("Gyroscope bias, magnitude", "rad/s"),
    "imuN_accel_bias": ("Accelerometer bias, magnitude", "m/s²"),
    "segmentN_mass": ("Mass of a segment", "kg"),
    "segmentN_length": ("Length of a segment", "m"),
}
LIMITS = (
    "Simulated throughout: motion is prescribed and smooth, or a free swing; no contact, no joint that gives way.",
    "Mounts are rigid or on linear springs and dampers; skin and muscle are neither.",
    "IMU profiles are models of datasheets and papers; a part in a laboratory may behave otherwise.",
    "Bias instability and random walk are in the samples; their course over time is not stored.",
    "A score on these recordings is no claim about recordings of people: test on real ones too.",
)
STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 980px; margin: 2rem auto; padding: 0 1rem; color: #1c2733; }
h1 { margin-bottom: 0; } .soft, figure p { color: #5a6876; } table { border-collapse: collapse; }
td, th { text-align: left; padding: .2rem 1.2rem .2rem 0; border-bottom: 1px solid #e3e8ed; }
.all { display: flex; flex-wrap: wrap; gap: 1rem 2rem; } figure { margin: 0; width: 300px; }
figcaption { font-weight: 600; } figure p { font-size: 13px; margin: 0; } svg text { font-size: 12px; fill: #1c2733; }
svg rect { fill: #1f6fb4; } svg line { stroke: #1c2733; } pre { background: #f4f6f8; padding: 1rem; overflow-x: auto; }
"""


def _doubles() -> "array[float]":
    return array("d")  # eight bytes a number, for datasets of a million


@dataclass
class Census:
    """What the tables of recordings say, counted."""

    names: dict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    numbers: "dict[str, array[float]]" = field(default_factory=lambda: defaultdict(_doubles))
    effects: Counter[str] = field(default_factory=Counter)  # recordings with it, anywhere
    parameters: "dict[tuple[str, str], array[float]]" = field(default_factory=lambda: defaultdict(_doubles))
    splits: dict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))  # split -> family


def card(spec: Spec, manifest: Mapping[str, Any], tables: Iterable[Path | IO[bytes]]) -> str:
    """Return the card of a dataset from its manifest and its files of recordings."""
    found = census(tables)
    total = sum(manifest["recordings"].values())
    size = sum(file["bytes"] for file in manifest["files"].values())
    parts = [
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{escape(spec.name)}</title>",
        f"<meta name='viewport' content='width=device-width, initial-scale=1'><style>{STYLE}</style></head><body>",
        f"<h1>{escape(spec.name)}</h1><p class='soft'>{escape(spec.summary)}</p>",
        f"<p>{total:,} simulated recordings of {manifest['rigs']:,} rigs, {manifest['seconds'] / 3600:,.2f} h at "
        f"{spec.rate:g} Hz, {manifest['samples']:,} rows, {size / 1e6:,.1f} MB. Licence of the data: "
        f"<b>{escape(spec.terms.licence or 'none stated')}</b>.</p>",
        "<h2>Splits, by rig</h2>",
        _splits(spec, found.splits),
        "<h2>What is in it</h2><div class='all'>",
        shares(found.names["family"], "Rig families", total),
        shares(found.names["motion"], "Motions", total),
        shares(found.names["imu1_profile"], "IMU profiles", total),
        shares(found.effects, "Effects, recordings with it", total),
        *(histogram(np.array(found.numbers[key]), *NUMBERS[key]) for key in NUMBERS),
        "</div>",
        "<h2>Effects, parameter by parameter</h2><div class='all'>" if found.parameters else "",
        *(_parameter(effect, key, values) for (effect, key), values in sorted(found.parameters.items())),
        "</div>" if found.parameters else "",
        "<h2>Known limits</h2><ul>",
        *(f"<li>{escape(limit)}</li>" for limit in limits(spec)),
        "</ul><h2>How to make it again</h2>",
        f"<pre>imubench generate spec/{SPEC_FILE} --count {total} --seed {manifest['seed']}</pre>",
        f"<p>With {escape(', '.join(f'{k} {v}' for k, v in manifest['versions'].items()))} on "
        f"{escape(manifest['machine'])}: the same bytes. The spec:</p>",
        f"<pre>{escape(manifest['spec_text'])}</pre></body></html>",
    ]
    return "\n".join(part for part in parts if part) + "\n"


def limits(spec: Spec) -> Sequence[str]:
    """Return what a user should know before he trusts a result."""
    own = [f"Signals and truth are rounded to {'24' if spec.precision == 'single' else '53'} bits."]
    if spec.truth != "full":
        own.append(f"Of the truth, {'the core alone is' if spec.truth == 'core' else 'nothing is'} stored.")
    if not spec.effects and not any(r.soft.probability or r.rocking.probability for r in spec.rigs):
        own.append("No left-out physics: beyond what the IMU profiles have, every recording obeys its model.")
    return (*LIMITS, *own)


def census(tables: Iterable[Path | IO[bytes]]) -> Census:
    """Return what is in the files of recordings, read one after the other."""
    found = Census()
    for path in tables:
        with opened_parquet(path, "a table of recordings") as table:
            for i, row in enumerate(table.read(use_threads=False).to_pylist()):
                try:
                    _count(found, row)
                except InputError:
                    raise
                except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
                    raise InputError(
                        f"{path}: row {i}: expected a recording as `imubench generate` writes it, got {error!r}"
                    ) from None
    return found


def _count(found: Census, row: Mapping[str, Any]) -> None:
    if not is_rig(row["family"]):
        raise LookupError(row["family"])
    for key in NAMES:
        found.names[key][row[key]] += 1
    found.splits[row["split"]][row["family"]] += 1
    for key in NUMBERS:
        for n in range(1, len(rig_tree(row["family"]).imus) + 1):
            if "N" in key or n == 1:
                found.numbers[key].append(_size(row[key.replace("N", str(n))]))
    found.effects.update({e["effect"] for e in row["effects"]})
    for e in row["effects"]:
        if e["effect"] not in EFFECTS:
            raise unknown("effect", e["effect"], EFFECTS)
        for key, value in parse_json(e["parameters"].encode(), "effects").items():
            if not isinstance(value, str) and key != "channels" and (key, value) != ("gyration", GYRATION):
                found.parameters[e["effect"], key].extend(np.ravel(value).tolist())


def _size(value: Any) -> float:
    return float(np.linalg.norm(value))


def _parameter(effect: str, key: str, values: Sequence[float]) -> str:
    law = EFFECTS[effect]
    units = {p.name: p.unit for p in law.parameters} | {f.name: f.unit for f in law.found}
    found = np.array(values)
    if not found.size:
        return ""
    spread = key != "times" and found.min() > 0 and found.max() > 20 * found.min()
    unit = units.get(key, "").replace("^2", "²").replace("^3", "³")
    return histogram(found, f"{effect}: {key}", "" if unit == "1" else unit, log=bool(spread))


def _splits(spec: Spec, found: Mapping[str, Counter[str]]) -> str:
    families = sorted({family for counts in found.values() for family in counts})
    head = "".join(f"<th>{escape(family)}</th>" for family in families)
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td>{sum(found[name].values()) if name in found else 0}</td>"
        + "".join(f"<td>{found[name][f] if name in found else 0}</td>" for f in families)
        + "</tr>"
        for name in spec.splits
    )
    return f"<table><tr><th>split</th><th>recordings</th>{head}</tr>{rows}</table>"
