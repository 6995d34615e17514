from .entry import opened, read

__all__ = ["opened", "read"]
