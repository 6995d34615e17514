"""Work in started processes that fails, or ends its process; the module imports only what it needs."""

import os
import signal

from sigmatau.errors import OptionError


def killed(log):
    os.kill(os.getpid(), signal.SIGKILL)


def ended(log):
    os._exit(7)


def refused(log):
    raise OptionError("no such unit", option="unit")
