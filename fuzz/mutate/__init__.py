"""Mutators, one a format. Each takes valid content and a random generator, and returns content that may be broken."""

from collections.abc import Callable
from random import Random

Mutate = Callable[[bytes, Random], bytes]
"""The protocol: the same content and the same state of the generator give the same bytes. It never raises."""
