"""Bytes changed without any idea of what they mean: flips, cuts, copies, sizes overwritten."""

from random import Random

SIZES = (0, 1, 7, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 2**63 - 1, 2**64 - 1)
MOST = 300_000  # bytes that an input may grow to


def mutate(content: bytes, rng: Random) -> bytes:
    """Return content with one to eight changes anywhere."""
    out = bytearray(content)
    for _ in range(1 + min(int(rng.expovariate(0.5)), 7)):
        out = _change(out, rng)
    return bytes(out[:MOST])


def flip(content: bytes, rng: Random) -> bytes:
    """Return content of the same size in which some bits are others: a file on a disk that rots."""
    out = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 8, 64))):
        if out:
            out[rng.randrange(len(out))] ^= 1 << rng.randrange(8)
    return bytes(out)


def _change(out: bytearray, rng: Random) -> bytearray:
    if not out:
        return bytearray(rng.randbytes(rng.choice((0, 1, 16, 1_000))))
    kind, at = rng.randrange(12), rng.randrange(len(out))
    end = min(len(out), at + rng.choice((1, 2, 4, 16, 256, 4_096)))
    if kind < 3:
        out[at] ^= 1 << rng.randrange(8)
    elif kind == 3:
        out[at] = rng.choice((0, 1, 0x7F, 0x80, 0xFF, 10, 34, 44, rng.randrange(256)))
    elif kind == 4:
        del out[at:end]
    elif kind == 5:
        out[at:at] = out[at:end]
    elif kind == 6:
        out[at:at] = rng.randbytes(end - at)
    elif kind == 7:
        out[at:end] = bytes(end - at)
    elif kind == 8:
        del out[at:]
    elif kind == 9:
        width = rng.choice((1, 2, 4, 8))
        value = rng.choice(SIZES) % (1 << 8 * width)
        out[at : at + width] = value.to_bytes(width, rng.choice(("little", "big")))
    elif kind == 10:
        other = rng.randrange(len(out))
        out[at:end] = out[other : other + end - at]
    else:
        out *= rng.choice((2, 3)) if len(out) < MOST // 3 else 1
    return out
