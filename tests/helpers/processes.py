"""Processes that tests start, and whether they have ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

PATIENCE_SECONDS = 300.0
"""After this wait a test fails; what is waited for comes at once, and on a slow machine soon."""


def child_environment() -> dict[str, str]:
    """Return an environment in which a child imports what this process can."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(entry for entry in sys.path if entry)}


def start_process(arguments: list[str], **options: Any) -> subprocess.Popen[Any]:
    """Start a process that Ctrl-C stops, even where this one ignores it, as jobs in the background of a shell do."""
    return subprocess.Popen(arguments, preexec_fn=_heed_interrupts, **options)


def _heed_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def ends(process: int) -> bool:
    """Whether a process that is not ours ends; one that waits to be collected has ended."""
    limit = time.monotonic() + PATIENCE_SECONDS
    while time.monotonic() < limit:
        try:
            if Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                return True
        except FileNotFoundError:
            return True
        time.sleep(0.05)
    return False


def interrupt(process: subprocess.Popen[Any]) -> tuple[Any, Any]:
    """Press Ctrl-C until a process ends, and return what it printed.

    Once is not always enough: Python drops the exception of a signal that arrives inside a finaliser or a callback.
    """
    while True:
        process.send_signal(signal.SIGINT)
        try:
            return process.communicate(timeout=60.0)
        except subprocess.TimeoutExpired:
            assert process.poll() is None
