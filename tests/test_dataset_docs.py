"""What docs/datasets.md shows works as it stands there, and says everything there is."""

import re
from pathlib import Path

import pytest

from imubench.dataset import parse_spec
from imubench.dataset.columns import schema
from imubench.dataset.generate import generate
from imubench.dataset.motion_ranges import KINDS, RandomMotion
from imubench.dataset.rig_ranges import KEYS as RIG_KEYS
from imubench.dataset.rig_ranges import NUMBERS, SPRING_NUMBERS
from imubench.dataset.rows import IMU, RECORDING, SEGMENT
from imubench.dataset.shard import Job
from imubench.dataset.spec import KEYS
from imubench.sim.injected import all_injectable
from tests.hub import offline

DOCS = Path(__file__).resolve().parent.parent / "docs"
PAGE = (DOCS / "datasets.md").read_text()
FIRST, SPEC = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
__all__ = ["offline"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("docs") / "DIR"
    generate(Job({"spec.toml": SPEC.encode()}, 0, 18, str(out)), workers=0)
    return out


@pytest.mark.long
def test_the_example_makes_what_it_says(folder):
    (block,) = (b for b in BLOCKS if "read(" in b)
    space: dict[str, object] = {}
    exec(block.replace("DIR", str(folder)), space)
    stored = space["stored"]
    assert stored.recording.name == "hinges-and-limbs-0000017"
    assert stored.truth.time[-1] <= 20


@pytest.mark.parametrize("package", ("pandas", "polars", "duckdb", "datasets", "mlcroissant"))
def test_other_readers_as_shown(folder, package, offline):
    (block,) = (b for b in BLOCKS if "pandas" in b)
    (part,) = (p for p in re.split(r"\n\n(?=import )", block) if p.startswith(f"import {package}"))
    exec(part.replace("DIR", str(folder)), {})


@pytest.mark.parametrize(
    "key",
    [*KEYS[1:], *RIG_KEYS, *NUMBERS, *SPRING_NUMBERS, *KINDS, *RandomMotion.DEFAULTS, *RECORDING],
)
def test_every_key_is_told(key):
    assert f"`{key}`" in PAGE or f"[[{key}]]" in PAGE


@pytest.mark.parametrize("effect", all_injectable())
def test_every_effect_is_on_the_page_that_is_named(effect):
    assert "[the effects](effects.md)" in PAGE
    assert f"### {effect}\n" in (DOCS / "effects.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("key", [*SEGMENT, *IMU])
def test_every_column_of_the_recordings_is_told(key):
    shown = key.replace("accel_", "gyro_") if key.endswith(("bias", "scale", "misalignment")) else key
    assert f"`{shown}`" in PAGE or shown in ("declared_position_std", "declared_rotation_std")  # told as `_std`


def test_every_column_of_the_samples_is_told():
    names = r"imuN_[\w.]+\*?|segmentN_\w+\*?|hinge_\w+|encoder_\w+|_\w+\*?|time|recording|split"
    shown = set(re.findall(rf"`({names})[`.]", PAGE))
    told = {re.sub(r"_?(\*|x\.\.z)$", "", name) for name in shown}
    for name in schema(parse_spec({"spec.toml": SPEC.encode()})).names:
        general = re.sub(r"^(imu|segment)\d", r"\1N", name)
        stem = re.sub(r"_[wxyz]$", "", general)
        short = re.sub(r"^(imuN_true|segmentN)", "", stem)
        assert {general, stem, short} & told, name
