"""Format 1 on disk: a folder with recording.toml and one table of numbers per sensor, read and written exactly."""

from imubench.format1.read import read, read_recording, read_reference
from imubench.format1.write import write_recording

__all__ = ["read", "read_recording", "read_reference", "write_recording"]
