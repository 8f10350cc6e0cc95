"""Input i of a reader under a seed: the same bytes on every machine."""

from functools import lru_cache
from random import Random

from fuzz.mutate import bytes as plain
from fuzz.reader import Reader

STRANGE = 0.02  # of the inputs are a valid file of another reader: a file in the wrong place
PLAIN = 0.08  # are broken without any idea of their format
BOTH = 0.08  # are broken in their structure and then as bytes


def content(reader: Reader, seed: int, index: int) -> bytes:
    """Return the content of the reader's target."""
    rng = Random(f"{seed}/{reader.name}/{index}")
    valid, kind = reader.files()[reader.target], rng.random()
    if kind < STRANGE:
        return rng.choice(_all())
    if kind < STRANGE + PLAIN:
        return plain.mutate(valid, rng)
    out = reader.mutate(valid, rng)
    return plain.mutate(out, rng) if kind > 1 - BOTH and reader.mutate is not plain.flip else out


@lru_cache(maxsize=1)
def _all() -> tuple[bytes, ...]:
    from fuzz.readers import READERS

    return tuple(reader.files()[reader.target] for reader in READERS.values())
