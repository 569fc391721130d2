"""Processes that tests start, and whether they have ended."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

PATIENCE_SECONDS = 300.0
"""After this wait a test fails; what is waited for comes at once, and on a slow machine soon."""


def child_environment() -> dict[str, str]:
    """Return an environment in which a child imports what this process can."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(entry for entry in sys.path if entry)}


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
