"""What the README and the Start page show is what the commands print today."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "docs" / "start.md"]
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")
NOT_RUN = ("git ", "python3 ", "pip ", "ocp-traj compare", ".venv/bin/")


def sessions(page: Path) -> list[tuple[str, list[str]]]:
    """Return the commands a page shows, each with the lines of output shown below it."""
    found: list[tuple[str, list[str]]] = []
    for block in re.findall(r"```console\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        for line in block.splitlines():
            if line.startswith("$ "):
                found.append((line[2:], []))
            else:
                found[-1][1].append(line)
    return found


def similar(shown: str, printed: str) -> bool:
    """Whether two lines say the same: equal words, and numbers within 0.1 % (seconds and counts of cost aside)."""
    if shown.lstrip().startswith("cost"):
        return printed.lstrip().startswith("cost")
    if NUMBER.sub("#", shown).split() != NUMBER.sub("#", printed).split():
        return False
    pairs = zip(NUMBER.findall(shown), NUMBER.findall(printed))
    return all(float(a) == pytest.approx(float(b), rel=1e-3) for a, b in pairs)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_commands_of_a_page_print_what_it_shows(page: Path, tmp_path: Path, monkeypatch, capsys) -> None:
    from ocp_traj.cli.main import run

    monkeypatch.chdir(tmp_path)
    commands = [entry for entry in sessions(page) if not entry[0].startswith(NOT_RUN)]
    assert commands
    for command, shown in commands:
        program, *arguments = shlex.split(command)
        assert program == "ocp-traj"
        assert run(arguments) == 0, command
        printed = [line for line in capsys.readouterr().out.splitlines() if line.strip()]
        for expected in filter(str.strip, shown):
            assert any(similar(expected, line) for line in printed), (
                f"{command}: {expected!r} not in {printed}"
            )


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_python_of_a_page_runs(page: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, str(page), "exec"), names)
    assert names["result"].feasible


def test_every_public_name_has_a_docstring_and_a_place_in_the_reference() -> None:
    import ocp_traj

    reference = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    for name in set(ocp_traj.__all__) - {"__version__"}:
        assert getattr(ocp_traj, name).__doc__, name
        assert re.search(rf":: {name}$", reference, re.MULTILINE), f"{name} is missing in docs/api.md"
    import metaheuristics

    for name in metaheuristics.__all__:
        subject = getattr(metaheuristics, name)
        assert not callable(subject) or subject.__doc__, name
