"""Lines and tokens of any text format changed: what an editor, a spreadsheet or half a copy does to a file."""

import re
from random import Random

from fuzz.mutate import nasty

TOKEN = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?|\"[^\"\n]*\"|'[^'\n]*'|[A-Za-z_]+")
LINES = 200_000  # that one line may become
MOST = 10_000_000  # characters that repeated lines add: a file of one line, doubled and doubled, would fill the memory


def mutate(content: bytes, rng: Random) -> bytes:
    """Return text with one to four changes to its lines, its tokens or its encoding."""
    text = content.decode("utf-8", errors="replace")
    for _ in range(1 + min(int(rng.expovariate(1.0)), 3)):
        text = _token(text, rng) if rng.random() < 0.4 else _lines(text, rng)
    return _encoded(text, rng)


def _token(text: str, rng: Random) -> str:
    found = list(TOKEN.finditer(text))
    if not found:
        return text
    token = rng.choice(found)
    kind = rng.randrange(5)
    if kind == 0:
        new = str(rng.choice(("9" * nasty.DIGITS, "1e400", "-1e400", "nan", "inf", "-0", "0x1F", "1_0", "٣", "1,5")))
    elif kind == 1:
        new = '"' + nasty.text(rng) + '"'
    elif kind == 2:
        new = nasty.text(rng)
    elif kind == 3:
        new = rng.choice(found)[0]
    else:
        new = rng.choice(("", token[0] * 2, token[0][:-1], "[" + token[0] + "]", "{" + token[0] + "}", "-" + token[0]))
    return text[: token.start()] + new + text[token.end() :]


def _lines(text: str, rng: Random) -> str:
    lines = text.splitlines(keepends=True) or [""]
    at = rng.randrange(len(lines))
    kind = rng.randrange(9)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(at, rng.choice(lines))
    elif kind == 2:
        other = rng.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == 3:
        del lines[at:]
    elif kind == 4:
        lines[at] = lines[at][: rng.randint(0, len(lines[at]))]
    elif kind == 5:
        line = lines[rng.randrange(len(lines))]
        often = rng.choice((1, 1_000, LINES if rng.random() < 0.02 else 10))
        lines += [line] * min(often, max(1, MOST // max(1, len(line))))
    elif kind == 6:
        lines.insert(
            at, rng.choice(("\n", "#\n", "# note\n", "\x00\n", ";\n", "=\n", ",,,,\n", "x" * nasty.CELL + "\n"))
        )
    elif kind == 7:
        lines.append(rng.choice(("x", "1", '"', "'''", "[", "]]", "{", "\x1a", "\x00" * 512)))
    else:
        rng.shuffle(lines)
    return "".join(lines)


def _encoded(text: str, rng: Random) -> bytes:
    kind = rng.randrange(40)
    if kind == 0:
        text = text.replace("\n", "\r\n")
    elif kind == 1:
        text = text.replace("\n", "\r")
    elif kind == 2:
        text = text.replace("\n", "\r\n", rng.randint(1, 5))
    elif kind == 3:
        text = "\ufeff" + text
    elif kind == 4:
        return text.encode(rng.choice(("utf-16", "utf-32", "utf-16-le", "utf-8-sig")), "surrogatepass")
    elif kind == 5:
        return text.encode("latin-1", errors="replace") + b"\xe9\xff"
    elif kind == 6:
        text = text.rstrip("\n")
    return text.encode("utf-8", "surrogatepass")
