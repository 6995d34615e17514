"""Loaded by each worker process of this host when it starts. Ctrl-C is ignored, because the client stops the workers."""

from __future__ import annotations

import signal
import threading

from sigmatau.lab.fleet.tasks import prepare_process

if threading.current_thread() is threading.main_thread():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
prepare_process()
