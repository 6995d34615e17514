"""Files: logs into records, records into tables."""

from sigmatau.io.read import read
from sigmatau.io.read.frame import from_frame
from sigmatau.io.write import write_record

__all__ = ["from_frame", "read", "write_record"]
