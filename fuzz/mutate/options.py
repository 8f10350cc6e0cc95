"""Options `key=value`, a line each, as they come from a command line."""

from random import Random

from fuzz.mutate import nasty

PIECES = (
    "=",
    ",",
    "time=",
    "gyr_x=",
    "gyr_x=wx,gyr_x=wy",
    "==",
    "a=b=c",
    "time=time",
    "acc_x=gyr_x",
    ",,",
    "gyr_x=,acc_x=",
)


def mutate(content: bytes, rng: Random) -> bytes:
    """Return options with changed keys, values or signs."""
    lines = content.decode().splitlines()
    for _ in range(1 + min(int(rng.expovariate(1.0)), 3)):
        at = rng.randrange(len(lines))
        key, _, value = lines[at].partition("=")
        kind = rng.randrange(8)
        if kind == 0:
            value = str(nasty.number(rng)) if rng.random() < 0.9 else "9" * nasty.DIGITS
        elif kind == 1:
            value = nasty.text(rng)
        elif kind == 2:
            value = rng.choice(PIECES) + value
        elif kind == 3:
            key = rng.choice((nasty.text(rng), key.upper(), key + " ", "", "-" + key))
        elif kind == 4:
            value = rng.choice(lines).partition("=")[2]
        elif kind == 5:
            value = value[: rng.randint(0, len(value))]
        elif kind == 6:
            lines.append(rng.choice(lines))
        lines[at] = f"{key}={value}" if rng.random() < 0.95 else key
    joined = "\n".join(" ".join(line.split("\n")) for line in lines)
    return joined.replace("\0", "").encode("utf-8", "replace")  # no argument of a program holds a null
