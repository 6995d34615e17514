from .folders import is_log
from .read.formats.split import bag_files
from .read.options import ReadOptions
from .read.registry import NOT_LOGS

__all__ = [
    "NOT_LOGS",
    "ReadOptions",
    "bag_files",
    "is_log",
]
