"""Tables as CSV: header, rows and cells changed; for files with lines above the header, `below(lines)`."""

from functools import lru_cache
from random import Random

from fuzz.mutate import Mutate, nasty, text

MANY = 2_000_000  # rows above a bad last line, or as many as make
BYTES = 40_000_000
MILD = 0.35  # of the tables have other numbers alone: what follows reading is tried too
FACTORS = (0.0, -1.0, 1e-9, 1e-3, 0.5, 2.0, 57.3, 1e3, 1e6, 1e12)
CELLS = (
    "", " ", "nan", "NaN", "inf", "-inf", "1e400", "1_000", "1,5", "abc", '"', '"1"', "'1'", "0x10", "true", "null",
    "NA", "-", "1.2.3", "٣", "1e-400", "--1", "+1", "1 2", "\x00", "\x1b[31m", "#", "=1+1", "9" * nasty.DIGITS,
    "1e308", "-1e308",
    "1e30", "-0.0", "\ufeff1", "2020-01-01", "12:30:00",
)  # fmt: skip


def below(lines: int) -> Mutate:
    """Return the mutator of CSV files whose header stands below so many lines."""

    def mutate_below(content: bytes, rng: Random) -> bytes:
        if rng.random() < 0.25:
            return text.mutate(content, rng)
        *above, body = content.split(b"\n", lines)
        if rng.random() < 0.15:
            above = text.mutate(b"\n".join(above), rng).split(b"\n")
        return b"\n".join([*above, _mutated(body, rng)])

    return mutate_below


def _mutated(content: bytes, rng: Random) -> bytes:
    rows = [line.split(",") for line in content.decode("utf-8", errors="replace").splitlines()] or [[""]]
    if rng.random() < MILD:
        return _written(_numbers(rows, rng))
    if rng.random() < 0.002:
        return many(",".join(rows[0]), len(rows[0]))
    for _ in range(1 + min(int(rng.expovariate(1.0)), 3)):
        rows = _change(rows, rng) or [[""]]
    separator = rng.choice((",",) * 30 + (";", "\t", " ", ", ", ",,"))
    end = rng.choice(("\n",) * 20 + ("\r\n", "\r", "\n\n", ",\n"))
    return _written(rows, separator, end)


def _written(rows: list[list[str]], separator: str = ",", end: str = "\n") -> bytes:
    return (end.join(separator.join(row) for row in rows) + end).encode("utf-8", "surrogatepass")


def _numbers(rows: list[list[str]], rng: Random) -> list[list[str]]:
    """Return rows with other numbers, fewer rows or columns in another order: a table that may well be accepted."""
    header, body = rows[0], rows[1:]
    width = len(header)
    chosen = sorted(rng.sample(range(width), rng.choice((1, min(3, width), width))))
    kind = rng.randrange(8)
    if kind == 0:
        first = rng.randrange(max(len(body), 1))
        return [header, *body[first : first + rng.choice((1, 2, 3, 5, 8, 20, 60))]]
    if kind == 1:
        order = rng.sample(range(width), width)
        return [[row[k] for k in order if k < len(row)] for row in rows]
    if kind == 2:
        drop = rng.randrange(len(body)) if body else 0
        return [header, *body[:drop], *body[drop + rng.choice((1, 10, 50)) :]]
    if kind == 3:
        return [header, *(row for row in body for _ in range(rng.choice((1, 1, 1, 2))))]
    factor, offset = rng.choice(FACTORS), rng.choice((0.0, 0.0, 1.0, -5.0, 1e6))
    held, at = body[0] if body else [], rng.randrange(max(len(body), 1))
    out = [list(row) for row in body]
    for r, row in enumerate(out):
        for c in chosen:
            if c >= len(row):
                continue
            if kind == 4:
                row[c] = held[c] if c < len(held) else row[c]
            elif kind == 5 and r == at:
                row[c] = rng.choice(("1e6", "-1e6", "0", "50", ""))
            elif kind > 5:
                row[c] = _scaled(row, c, factor, offset)
    return [header, *out]


mutate: Mutate = below(0)
mutate_diodem: Mutate = below(2)


def _change(rows: list[list[str]], rng: Random) -> list[list[str]]:
    kind, r = rng.randrange(16), rng.randrange(len(rows))
    row = rows[r] or [""]
    c = rng.randrange(len(row))
    if kind < 4:
        row[c] = rng.choice(CELLS) if rng.random() < 0.9 else "x" * nasty.CELL
    elif kind == 4:
        rows[0] = [*rows[0][:c], nasty.text(rng), *rows[0][c + 1 :]]
    elif kind == 5:
        rows[0] = rng.choice(
            (rows[0][::-1], rows[0] * 2, [*rows[0], "extra"], rows[0][:-1], [], [f'"{n}"' for n in rows[0]])
        )
    elif kind == 6:
        rows[0] = [*rows[0], *(f"c{i}" for i in range(30_000))] if rng.random() < 0.5 else [*rows[0], "x" * nasty.CELL]
    elif kind == 7:
        rows = [row[:c] + row[c + 1 :] for row in rows]
    elif kind == 8:
        rows = [[*row, row[c % len(row)] if row else ""] for row in rows]
    elif kind == 9:
        rows = rows[: rng.choice((0, 1, 2, 3, 4, 6, 8))]
    elif kind == 10:
        rows = rows[:1] + rows[:0:-1]
    elif kind == 11:
        rows.insert(r, list(row))
    elif kind == 12:
        rows[r] = row + row if rng.random() < 0.5 else row[:c]
    elif kind == 13:
        value = rng.choice(CELLS)
        rows = rows[:1] + [[*row[:c], value, *row[c + 1 :]] for row in rows[1:]]
    elif kind == 14:
        rows = rows[1:]
    else:
        factor = rng.choice(FACTORS)
        rows = rows[:1] + [[*row[:c], _scaled(row, c, factor), *row[c + 1 :]] for row in rows[1:]]
    return rows


def _scaled(row: list[str], c: int, factor: float, offset: float = 0.0) -> str:
    try:
        return repr(float(row[c]) * factor + offset)
    except (ValueError, IndexError):
        return "0"


@lru_cache(maxsize=1)
def many(header: str, columns: int) -> bytes:
    """Return a table of very many rows whose last one is broken."""
    cells = ",1" * (columns - 1) + "\n"
    rows = min(MANY, BYTES // (len(cells) + 7))
    body = "".join(f"{i}{cells}" for i in range(rows))
    return f"{header}\n{body}x\n".encode()
