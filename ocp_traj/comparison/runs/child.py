"""The process a run happens in: it reads specifications, writes records, and may be killed at any time.

Started by `ocp_traj.comparison.runs.supervisor` as ``python -m ocp_traj.comparison.runs.child MODULE``. Messages are
lines of JSON: requests on standard input, answers on what was standard output. Standard output itself is
turned into standard error first, because native solvers print there.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import threading
import time
import traceback
from collections.abc import Callable
from typing import Any, BinaryIO

_PR_SET_PDEATHSIG = 1
_SIGKILL = 9


def main() -> None:
    """Serve requests until standard input ends."""
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    die_with_parent()
    module = importlib.import_module(sys.argv[1])
    warm_up: Callable[[], None] | None = getattr(module, "warm_up", None)
    if warm_up is not None:
        warm_up()
    _send(channel, {"state": "ready"})
    for line in sys.stdin.buffer:
        _send(channel, _serve(json.loads(line)))


def _serve(request: dict[str, Any]) -> dict[str, Any]:
    started = time.perf_counter()
    try:
        with MemoryCap(request.get("memory_limit")):
            answer = load_function(request["runner"])(request)
    except MemoryError:
        return {
            "state": "error",
            "reason": "memory limit",
            "message": "the run asked for more memory than it may take",
        }
    except Exception as error:  # a solver's own bug is a row, not the end of the comparison
        last = traceback.format_exc().strip().splitlines()[-1]
        place = traceback.extract_tb(error.__traceback__)[-1]
        return {
            "state": "error",
            "reason": "error",
            "message": f"{last} ({os.path.basename(place.filename)}, line {place.lineno})",
        }
    return {"state": "done", "answer": answer, "seconds": time.perf_counter() - started}


def _send(channel: BinaryIO, message: dict[str, Any]) -> None:
    channel.write(json.dumps(message).encode() + b"\n")
    channel.flush()


def load_function(path: str) -> Callable[[dict[str, Any]], Any]:
    """Return the function named ``module:function``."""
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)


class MemoryCap:
    """Let the operating system refuse memory beyond what is mapped now plus `allowance` bytes (Linux)."""

    def __init__(self, allowance: int | None) -> None:
        self.allowance = allowance
        self.before: tuple[int, int] | None = None

    def __enter__(self) -> None:
        mapped = mapped_bytes()
        if self.allowance is None or mapped is None:
            return
        import resource

        self.before = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (mapped + self.allowance, self.before[1]))

    def __exit__(self, *_: object) -> None:
        if self.before is not None:
            import resource

            resource.setrlimit(resource.RLIMIT_AS, self.before)


def mapped_bytes() -> int | None:
    """Return the size of this process's address space, or None where /proc does not tell."""
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return None


def die_with_parent() -> None:
    """End this process when its starter ends: at once on Linux, even inside native code, else soon after."""
    parent = os.getppid()
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, _SIGKILL)
    if os.getppid() != parent:
        os._exit(1)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


if __name__ == "__main__":
    main()
