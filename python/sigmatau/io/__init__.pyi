from .read.formats.split import files_of
from .read.options import ReadOptions
from .read.registry import NOT_LOGS

__all__ = [
    "NOT_LOGS",
    "ReadOptions",
    "files_of",
]
