"""The process a run lives in: what it answers, what it may take, and that it does not outlive its parent."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from helpers import comparison_fakes as fakes
from ocp_traj.comparison.runs import child, environment, supervisor
from ocp_traj.comparison.runs.plan import CaseChoice, Plan


def request(solver: str, **changes: Any) -> dict[str, Any]:
    plan = Plan((CaseChoice("one"),), (solver,), seeds=1, references=False, runner=fakes.RUNNER)
    return {**plan.runs(fakes.identify)[0].to_json(), **changes}


def test_requests_are_answered_line_by_line_and_printing_does_not_disturb(tmp_path: Path) -> None:
    (tmp_path / "noisy_runner.py").write_text(
        "import os\n"
        "def run(request):\n"
        "    print('from Python')\n"
        "    os.write(1, b'from a native solver\\n')\n"
        "    return {'seed': request['seed']}\n"
    )
    lines = [{"runner": "noisy_runner:run", "seed": seed} for seed in (4, 5)]
    done = subprocess.run(
        [sys.executable, "-m", "ocp_traj.comparison.runs.child", "noisy_runner"],
        input="".join(json.dumps(line) + "\n" for line in lines),
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), supervisor._search_path()])},
        check=True,
        timeout=60,
    )
    ready, *answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert ready == {"state": "ready"}
    assert [(answer["state"], answer["answer"]) for answer in answers] == [
        ("done", {"seed": 4}),
        ("done", {"seed": 5}),
    ]
    assert all(answer["seconds"] >= 0 for answer in answers)
    assert "from Python" in done.stderr and "from a native solver" in done.stderr


def test_an_error_is_an_answer_with_its_place() -> None:
    answer = child._serve(request("raise"))
    assert (answer["state"], answer["reason"]) == ("error", "error")
    assert answer["message"].startswith("ZeroDivisionError: the solver's own bug (comparison_fakes.py, line ")


def test_memory_that_is_refused_is_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: dict[str, Any]) -> None:
        raise MemoryError

    monkeypatch.setattr(fakes, "run", refuse)
    answer = child._serve(request("good"))
    assert (answer["state"], answer["reason"]) == ("error", "memory limit")


def test_a_memory_cap_ends_with_the_run() -> None:
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    with child.MemoryCap(2**30):
        inside = resource.getrlimit(resource.RLIMIT_AS)
        mapped = child.mapped_bytes()
    assert mapped is not None
    assert abs(inside[0] - (mapped + 2**30)) < 2**28 and inside[1] == before[1]
    assert resource.getrlimit(resource.RLIMIT_AS) == before


def test_without_a_cap_or_without_proc_nothing_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    with child.MemoryCap(None):
        assert resource.getrlimit(resource.RLIMIT_AS) == before

    def refuse(*_: Any) -> None:
        raise FileNotFoundError

    monkeypatch.setattr("builtins.open", refuse)
    assert child.mapped_bytes() is None
    with child.MemoryCap(1):
        assert resource.getrlimit(resource.RLIMIT_AS) == before


@pytest.mark.parametrize("platform", [sys.platform, "elsewhere"])
def test_a_child_does_not_outlive_its_parent(tmp_path: Path, platform: str) -> None:
    """At once through the kernel on Linux; elsewhere the child looks once a second."""
    script = (
        "import subprocess, sys\n"
        "code = '''import sys, time\n"
        f"sys.platform = {platform!r}\n"
        "from ocp_traj.comparison.runs.child import die_with_parent\n"
        "die_with_parent()\n"
        'print("ready", flush=True)\n'
        "time.sleep(60)'''\n"
        "process = subprocess.Popen([sys.executable, '-c', code], stdout=subprocess.PIPE)\n"
        "process.stdout.readline()\n"
        "print(process.pid)\n"
    )
    env = {**os.environ, "PYTHONPATH": supervisor._search_path()}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=env, check=True)
    assert ends(int(done.stdout), 20.0)


def ends(process: int, seconds: float) -> bool:
    """Whether a process that is not ours ends in time; one that waits to be collected has ended."""
    limit = time.monotonic() + seconds
    while time.monotonic() < limit:
        try:
            if Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
                return True
        except FileNotFoundError:
            return True
        time.sleep(0.05)
    return False


def test_a_child_that_cannot_start_is_a_record_with_its_reason() -> None:
    supervised = supervisor.Supervisor("no_such_module")
    try:
        record = supervised.run(request("good"))
    finally:
        supervised.close()
    assert (record.status, record.reason) == ("failed", "crash")
    assert "exit status 1" in record.message and "No module named 'no_such_module'" in record.message


def test_a_child_that_grows_is_killed_with_what_it_took() -> None:
    supervised = supervisor.Supervisor("helpers.comparison_fakes")
    try:
        assert supervised.call(request("good"), None, None)["state"] == "done"
        assert supervised._process is not None
        supervised._idle_memory = -(2**30)  # as if the child had grown by 1 GiB since it was ready
        answer = supervised.call(request("sleep:5"), None, 2**29)
        assert supervised._process is None
    finally:
        supervised.close()
    assert (answer["state"], answer["reason"]) == ("error", "memory limit")
    assert answer["message"].endswith("MiB, killed at the limit of 512 MiB")
    assert answer["peak_memory"] > 2**29


def test_memory_of_a_process_that_is_gone_is_not_known() -> None:
    assert supervisor.resident_bytes(2**30) is None
    held = supervisor.resident_bytes(os.getpid())
    assert held is not None and held > 2**20


def test_an_environment_without_git_proc_or_a_package_is_described_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert environment._version("no-such-package") is None

    def refuse(*_: Any, **__: Any) -> None:
        raise FileNotFoundError

    monkeypatch.setattr(environment.platform, "processor", lambda: "a processor")
    with monkeypatch.context() as patch:
        patch.setattr(Path, "read_text", refuse)
        assert environment._processor() == "a processor"
    with monkeypatch.context() as patch:
        patch.setattr(environment.subprocess, "run", refuse)
        assert environment.git_state() is None
    with monkeypatch.context() as patch:
        patch.setattr(environment, "_git", lambda *_: None)
        assert environment.git_state() is None
    with monkeypatch.context() as patch:
        patch.setattr(sys, "platform", "win32")
        assert environment._memory_gb() is None
    memory = environment._memory_gb()
    assert memory is not None and memory > 0.1
