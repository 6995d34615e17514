"""Reading of log files into a `Record`.

`registry` finds the reader of a format from the content of the file. The reader returns columns. The rest is common to all
formats: channels (`columns`), the sampling rate (`time`), units (`resolve`) and the record (`assemble`).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
