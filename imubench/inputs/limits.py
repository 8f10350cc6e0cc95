"""How much a file may hold. Every limit of the readers stands here and is named in the message that it causes.

They are set so that reading any file stays below a gigabyte of memory and some seconds, and so that no recording of
a laboratory comes near them: 40 million numbers are seven columns of 5.7 million samples, 16 hours at 100 Hz.
"""

MEGABYTE = 2**20
TEXT_BYTES = 4 * MEGABYTE  # TOML, MJCF and small JSON: written by hand, or lists of a few thousand entries
JSON_BYTES = 64 * MEGABYTE  # the manifest of a dataset of five million recordings
TABLE_BYTES = 1024 * MEGABYTE  # a CSV of 40 million numbers of 25 characters
BINARY_BYTES = 512 * MEGABYTE  # Parquet, HDF5, MATLAB: their numbers fill eight bytes at most
NUMBERS = 40_000_000  # of the columns that are asked for: 320 MB as 64-bit numbers
COLUMNS = 4096  # of a table's header
LINE_CHARACTERS = 100_000  # of a line of a table: 4096 columns of 24 characters
DEPTH = 32  # tables or lists within each other, in TOML, JSON and MJCF: our own files have 5
ENTRIES = 1_000_000  # values of a TOML or JSON file
SIZE = 1e30  # of a number: no measurement in any unit comes near, and its powers up to the tenth stay finite
INTEGER = 2**63  # the largest whole number that TOML promises, and that 64 bits hold
NAME_CHARACTERS = 200  # of a name that becomes a file's: file systems take 255 bytes, and we add to it
ELEMENTS = 10_000  # of an MJCF file: our largest rig has 100
PIXELS = 4096 * 4096  # of a texture or height field that an MJCF file has MuJoCo build
