"""A fuzzer of every reader that a command has: `python -m fuzz`, or `make fuzz`.

    readers.py   the visible list: one `Reader` for each file, or list of options, that a command takes in
    seeds/       a small valid input of each, made by the project's own writers
    mutate/      one mutator a format: `mutate(content, rng) -> bytes`, structure-aware, then written out again
    inputs.py    input i of reader R under seed S, which follows from these three alone
    scratch.py   where an input is laid out, what lies beside it, and what a read must leave as it was
    verdict.py   what came of an input: accepted, refused in one line, or failed
    worker.py    the process that reads, with its limits; pool.py watches it, and survives its death
    minimise.py  a failing input made smaller; corpus.py keeps it under tests/corpus, for every later build

It is a development tool and not part of the wheel. Coverage-guided fuzzers (Atheris) trace Python lines, which here are
few: the parsing is done by TOML, JSON, Arrow, HDF5 and MuJoCo. What pays is to break valid input where a reader looks.
"""
