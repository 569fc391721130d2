"""The process a run lives in: what it answers, what it may take, and that it does not outlive its parent."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from helpers import comparison_fakes as fakes
from helpers.processes import child_environment, ends
from ocp_traj.comparison.runs import child, environment, supervisor
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.comparison.runs.supervisor import Supervisor


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
    environment = child_environment()
    lines = [{"runner": "noisy_runner:run", "seed": seed} for seed in (4, 5)]
    done = subprocess.run(
        [sys.executable, "-m", "ocp_traj.comparison.runs.child", "noisy_runner"],
        input="".join(json.dumps(line) + "\n" for line in lines),
        capture_output=True,
        text=True,
        env={**environment, "PYTHONPATH": os.pathsep.join([str(tmp_path), environment["PYTHONPATH"]])},
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


@pytest.fixture(scope="module")
def supervised() -> Iterator[Supervisor]:
    """A child that serves the fake runs."""
    supervised = Supervisor("helpers.comparison_fakes")
    yield supervised
    supervised.close()


def process_of(supervised: Supervisor) -> int:
    """Return the identity of the process a run lives in."""
    return int(supervised.call(request("process"), None, None)["answer"]["message"])


def test_an_error_is_an_answer_with_its_place(supervised: Supervisor) -> None:
    answer = supervised.call(request("raise"), None, None)
    assert (answer["state"], answer["reason"]) == ("error", "error")
    assert answer["message"].startswith("ZeroDivisionError: the solver's own bug (comparison_fakes.py, line ")


def test_memory_that_is_refused_is_an_answer(supervised: Supervisor) -> None:
    answer = supervised.call(request("refused"), None, None)
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
        "time.sleep(3600)'''\n"
        "process = subprocess.Popen([sys.executable, '-c', code], stdout=subprocess.PIPE)\n"
        "process.stdout.readline()\n"
        "print(process.pid)\n"
    )
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, env=child_environment(), check=True)
    assert ends(int(done.stdout))


def test_a_child_that_cannot_start_is_a_record_with_its_reason() -> None:
    supervised = supervisor.Supervisor("no_such_module")
    try:
        record = supervised.run(request("good"))
    finally:
        supervised.close()
    assert (record.status, record.reason) == ("failed", "crash")
    assert "exit status 1" in record.message and "No module named 'no_such_module'" in record.message


def test_a_child_that_grows_is_killed_with_what_it_took(
    supervised: Supervisor, monkeypatch: pytest.MonkeyPatch
) -> None:
    process = process_of(supervised)
    monkeypatch.setattr(supervisor, "resident_bytes", lambda _: 2**31)  # much more than when it was ready
    answer = supervised.call(request("loop"), None, 2**29)
    assert ends(process)
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
    described = environment.describe_environment()
    assert described["versions"]["numpy"] and described["machine"]["memory_gb"] > 0.1

    def refuse(*_: Any, **__: Any) -> None:
        raise FileNotFoundError

    def lack(name: str) -> str:
        raise environment.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(environment.platform, "processor", lambda: "a processor")
    with monkeypatch.context() as patch:
        patch.setattr(Path, "read_text", refuse)
        assert environment.describe_environment()["machine"]["processor"] == "a processor"
    with monkeypatch.context() as patch:
        patch.setattr(environment.metadata, "version", lack)
        assert environment.describe_environment()["versions"]["numpy"] is None
    with monkeypatch.context() as patch:
        patch.setattr(environment.subprocess, "run", refuse)
        assert environment.git_state() is None
    with monkeypatch.context() as patch:
        untracked = subprocess.CompletedProcess([], 1, "", "")
        patch.setattr(environment.subprocess, "run", lambda *_, **__: untracked)
        assert environment.git_state() is None
    with monkeypatch.context() as patch:
        patch.setattr(sys, "platform", "win32")
        assert environment.describe_environment()["machine"]["memory_gb"] is None
