"""Known datasets and files into format 1: to add one, write its module and add its line below.

A converter returns objects; whoever called it writes them.
"""

from imubench.convert import broad, csv, diodem, multiarm
from imubench.convert.converter import Converted, Converter, Option

CONVERTERS: dict[str, Converter] = {
    "diodem": diodem.CONVERTER,
    "broad": broad.CONVERTER,
    "multiarm": multiarm.CONVERTER,
    "csv": csv.CONVERTER,
}

__all__ = ["CONVERTERS", "Converted", "Converter", "Option"]
