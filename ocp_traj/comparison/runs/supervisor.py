"""Run one specification at a time in a child process that can be stopped whatever it does."""

from __future__ import annotations

import atexit
import contextlib
import functools
import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import IO, Any

from ocp_traj.comparison.runs.environment import pinned_threads
from ocp_traj.comparison.runs.record import RunRecord

POLL_SECONDS = 0.02
START_SECONDS = 120.0
"""How long a child may take to import what it needs."""


GRACE_SECONDS = 5.0
"""What a run may take beyond its solver's time limit: loading the case, compiling, the audit."""


def hard_limit(time_limit: float) -> float:
    """Return after how many seconds a run is killed: its solver's limit, a tenth more, and the grace."""
    return 1.1 * time_limit + GRACE_SECONDS


class Supervisor:
    """Keeps one child process, hands it requests, and kills it at a limit.

    Parameters
    ----------
    module
        Module the child imports before it says it is ready.
    """

    def __init__(self, module: str) -> None:
        self.module = module
        self._process: subprocess.Popen[bytes] | None = None
        self._messages: queue.Queue[dict[str, Any] | None] = queue.Queue()
        self._errors: IO[bytes] | None = None
        self._idle_memory = 0
        self._path = ""

    def run(self, request: dict[str, Any]) -> RunRecord:
        """Execute one request and return its record; a crash or a limit is a record with its reason."""
        answer = self.call(request, request.get("time_limit"), request.get("memory_limit"))
        if answer["state"] == "done":
            values = {
                **answer["answer"],
                "wall_time": answer["seconds"],
                "peak_memory": answer["peak_memory"],
            }
            return RunRecord.from_json(values)
        status = "time_exhausted" if answer["reason"] == "time limit" else "failed"
        return RunRecord(
            status,
            answer["message"],
            answer["reason"],
            wall_time=answer["seconds"],
            peak_memory=answer["peak_memory"],
        )

    def call(
        self, request: dict[str, Any], time_limit: float | None, memory_limit: int | None
    ) -> dict[str, Any]:
        """Execute one request; the answer has ``state`` done or error, ``seconds`` and ``peak_memory``."""
        failure = self._start()
        if failure is not None:
            return failure
        process = self._process
        assert process is not None and process.stdin is not None
        started = time.monotonic()
        try:
            process.stdin.write(json.dumps(request).encode() + b"\n")
            process.stdin.flush()
        except BrokenPipeError:
            pass  # the child died between two runs: the wait below sees it and says how
        limit = None if time_limit is None else hard_limit(time_limit)
        answer = self._wait(started, limit, memory_limit)
        answer.setdefault("seconds", time.monotonic() - started)
        return answer

    def close(self) -> None:
        """Stop the child."""
        process, self._process = self._process, None
        if process is None:
            return
        if process.stdin is not None:
            with contextlib.suppress(BrokenPipeError):  # already gone
                process.stdin.close()
        _kill(process)
        if self._errors is not None:
            self._errors.close()

    def _start(self) -> dict[str, Any] | None:
        """Make sure a child is ready that can import what this process can; return a failure when it cannot be."""
        path = _search_path()
        if self._process is not None and self._process.poll() is None and path == self._path:
            return None
        self.close()
        self._path = path
        self._messages = queue.Queue()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - lives as long as the child
        self._process = subprocess.Popen(
            [sys.executable, "-m", "ocp_traj.comparison.runs.child", self.module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env={**os.environ, **pinned_threads(), "PYTHONPATH": path},
            start_new_session=True,
        )
        threading.Thread(target=_forward, args=(self._process, self._messages), daemon=True).start()
        started = time.monotonic()
        answer = self._wait(started, START_SECONDS, None)
        if answer["state"] == "ready":
            self._idle_memory = resident_bytes(self._process.pid) or 0
            return None
        return {**answer, "reason": "crash", "seconds": time.monotonic() - started, "peak_memory": None}

    def _wait(self, started: float, limit: float | None, memory_limit: int | None) -> dict[str, Any]:
        process = self._process
        assert process is not None
        peak = 0
        while True:
            try:
                message = self._messages.get(timeout=POLL_SECONDS)
            except queue.Empty:
                message = {}
            grown = max((resident_bytes(process.pid) or 0) - self._idle_memory, 0)
            peak = max(peak, grown)
            if message is None:
                return {**self._describe_death(process), "peak_memory": peak}
            if message:
                return {**message, "peak_memory": peak}
            if limit is not None and time.monotonic() - started > limit:
                self.close()
                text = f"did not stop by itself, killed after {limit:.4g} s"
                return {"state": "error", "reason": "time limit", "message": text, "peak_memory": peak}
            if memory_limit is not None and grown > memory_limit:
                self.close()
                text = f"took {grown / 2**20:.0f} MiB, killed at the limit of {memory_limit / 2**20:.0f} MiB"
                return {"state": "error", "reason": "memory limit", "message": text, "peak_memory": peak}

    def _describe_death(self, process: subprocess.Popen[bytes]) -> dict[str, Any]:
        code = process.wait()
        how = f"exit status {code}" if code >= 0 else signal.Signals(-code).name
        text = f"the process died: {how}"
        if self._errors is not None:
            size = self._errors.seek(0, os.SEEK_END)
            self._errors.seek(max(size - 2000, 0))
            lines = self._errors.read().decode(errors="replace").strip().splitlines()
            if lines:
                text += f" ({lines[-1][:300]})"
        self.close()
        return {"state": "error", "reason": "crash", "message": text}


def _forward(process: subprocess.Popen[bytes], messages: queue.Queue[dict[str, Any] | None]) -> None:
    assert process.stdout is not None
    with process.stdout:
        for line in process.stdout:
            try:
                messages.put(json.loads(line))
            except json.JSONDecodeError:
                break  # cut off in the middle: the child died while it wrote
    messages.put(None)


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kill the child and what it started; it leads its own process group."""
    with contextlib.suppress(ProcessLookupError):  # already gone
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _search_path() -> str:
    """Let the child import what this process can, the library included."""
    return os.pathsep.join(str(Path(entry).resolve()) for entry in sys.path if entry)


def resident_bytes(pid: int) -> int | None:
    """Return the memory a process holds, or None where /proc does not tell."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError):
        return None


_SUPERVISORS = threading.local()


def run_supervised(request: dict[str, Any]) -> dict[str, Any]:
    """Execute one request in this thread's own child; what every kind of worker calls.

    ``request["kind"]`` is ``"run"`` (default; the answer is a record) or ``"reference"``.
    """
    module = request["runner"].partition(":")[0]
    supervisors: dict[str, Supervisor] = _SUPERVISORS.__dict__
    if module not in supervisors:
        supervisors[module] = Supervisor(module)
        atexit.register(supervisors[module].close)
    supervisor = supervisors[module]
    if request.get("kind") == "reference":
        return supervisor.call(request, request.get("time_limit"), request.get("memory_limit"))
    return supervisor.run(request).to_json()


def run_in_worker_process(request: dict[str, Any]) -> dict[str, Any]:
    """Execute one request in a worker process: Ctrl-C is the comparison's, whose death ends the worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with_parent()
    return run_supervised(request)


@functools.cache
def _end_with_parent() -> None:
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.2)
        os._exit(1)  # nobody waits for this worker's answers; its child dies with it

    threading.Thread(target=watch, daemon=True).start()
