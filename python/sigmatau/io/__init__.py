"""Files: logs into records, records into tables."""

from sigmatau.io.read import read
from sigmatau.io.write import write_record

__all__ = ["read", "write_record"]
