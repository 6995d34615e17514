from .record import stream_name

__all__ = [
    "stream_name",
]
