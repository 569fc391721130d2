"""On what a comparison ran: versions, machine, threads and the state of the source tree."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
)
"""Environment variables that decide how many threads numerical libraries start."""

_PACKAGES = ("ocp-traj", "numpy", "scipy", "casadi", "pin", "toppra", "cvxpy", "clarabel", "joblib")


def pinned_threads() -> dict[str, str]:
    """Return the environment that keeps every numerical library to one thread."""
    return dict.fromkeys(THREAD_VARIABLES, "1")


def describe_environment() -> dict[str, Any]:
    """Return versions, machine, threads and git state as JSON values."""
    return {
        "python": platform.python_version(),
        "versions": {name: _version(name) for name in _PACKAGES},
        "machine": {
            "system": f"{platform.system()} {platform.release()}",
            "processor": _processor(),
            "cores": os.cpu_count(),
            "memory_gb": _memory_gb(),
        },
        "threads": {"runs": pinned_threads()},
        "git": git_state(),
    }


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass  # not Linux: platform knows a name too
    return platform.processor() or platform.machine()


def _memory_gb() -> float | None:
    if not hasattr(os, "sysconf") or sys.platform == "win32":
        return None
    return float(round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30, 1))


def git_state() -> dict[str, Any] | None:
    """Return commit and cleanness of the tree the library runs from, or None outside a git tree."""
    folder = Path(__file__).resolve().parent
    try:
        tracked = _git(folder, "ls-files", "--error-unmatch", "environment.py")
        if tracked is None:
            return None
        return {
            "commit": _git(folder, "rev-parse", "HEAD"),
            "clean": _git(folder, "status", "--porcelain", "-uno") == "",
        }
    except (OSError, subprocess.TimeoutExpired):
        return None


def _git(folder: Path, *arguments: str) -> str | None:
    done = subprocess.run(
        ["git", *arguments], cwd=folder, capture_output=True, text=True, timeout=10, check=False
    )
    return done.stdout.strip() if done.returncode == 0 else None
