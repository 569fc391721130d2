"""What the README and the pages show is what the code does today: every block of theirs is executed or parsed."""

from __future__ import annotations

import doctest
import importlib
import re
import runpy
import shlex
from pathlib import Path

import pytest

from ocp_traj.case.toml_files import parse_toml

ROOT = Path(__file__).parent.parent
README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "docs" / "papers").glob("*.md"))]
REPLAYED = [README, ROOT / "docs" / "start.md"]
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")
NOT_RUN = ("git ", "python3 ", "pip ", "ocp-traj compare", ".venv/bin/")


def blocks(page: Path, language: str) -> list[str]:
    """Return the contents of a page's blocks in one language."""
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)


def pages_with(language: str) -> list[Path]:
    """Return the pages that have blocks in one language."""
    return [page for page in PAGES if blocks(page, language)]


def sessions(page: Path) -> list[tuple[str, list[str]]]:
    """Return the commands a page shows, each with the lines of output shown below it."""
    found: list[tuple[str, list[str]]] = []
    for block in blocks(page, "console"):
        for line in block.replace("\\\n", " ").splitlines():
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


def name_of(page: Path) -> str:
    """Return a page's name for the list of tests."""
    return page.stem


@pytest.mark.parametrize("page", REPLAYED, ids=name_of)
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


@pytest.mark.parametrize("page", pages_with("console"), ids=name_of)
def test_every_command_of_a_page_has_options_that_exist(page: Path) -> None:
    import click

    from ocp_traj.cli.main import cli

    for command, _ in sessions(page):
        for part in command.split("&&"):
            program, *words = shlex.split(part, comments=True)
            if program.split("/")[-1] != "ocp-traj":
                continue
            context = click.Context(cli)
            name, found, arguments = cli.resolve_command(context, words)
            assert found is not None, command
            found.make_context(name, arguments)  # raises what a wrong option or value would raise


@pytest.mark.parametrize("page", pages_with("python"), ids=name_of)
def test_the_python_of_a_page_runs(page: Path, tmp_path: Path, monkeypatch) -> None:
    from ocp_traj.solving import SolveResult

    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "page"}
    for block in blocks(page, "python"):
        exec(compile(block, str(page), "exec", dont_inherit=True), names)
    assert all(value.feasible for value in names.values() if isinstance(value, SolveResult))


@pytest.mark.parametrize("page", pages_with("toml"), ids=name_of)
def test_the_toml_of_a_page_can_be_read(page: Path) -> None:
    from ocp_traj.comparison.runs.plan import plan_from_table

    for block in blocks(page, "toml"):
        tables = parse_toml(block, page.name)
        assert tables
        if "solvers" in tables:
            assert plan_from_table(tables, page.name).solvers == tuple(tables["solvers"])


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_the_links_of_a_page_lead_to_files(page: Path) -> None:
    text = re.sub(r"```.*?```|`[^`]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for link in re.findall(r"\]\(([^)\s#]+)", text):
        if "://" not in link and not link.startswith("auto_examples/"):
            assert (page.parent / link).is_file(), link


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_the_examples_a_page_names_exist(page: Path) -> None:
    for stem in re.findall(r"auto_examples/([\w/]+)\.rst", page.read_text(encoding="utf-8")):
        assert stem == "index" or (ROOT / "examples" / f"{stem}.py").is_file(), stem


def test_every_page_is_in_the_table_of_contents() -> None:
    for folder in (ROOT / "docs", ROOT / "docs" / "papers"):
        listed = set(
            re.findall(r"^([\w/-]+)$", (folder / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
        )
        assert {page.stem for page in folder.glob("*.md")} - {"index"} <= listed


def test_every_command_and_every_choice_of_an_option_is_on_the_page_of_commands() -> None:
    import click

    from ocp_traj.cli.main import cli

    page = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
    context = click.Context(cli)
    for name in cli.list_commands(context):
        assert f"`ocp-traj {name}" in page, name
        command = cli.get_command(context, name)
        for parameter in command.params:
            if isinstance(parameter, click.Option) and isinstance(parameter.type, click.Choice):
                assert all(f"`{choice}`" in page for choice in parameter.type.choices), parameter.name


EVERY_TABLE = """
schema = 1
name = "every-table"
waypoints = { joints = [[0, -1, 1, 0, 0, 0], [0.5, -1, 1, 0, 0, 0]] }
boundary = { velocity = "zero" }
spline = { virtual_knots = 1 }
objective = { time = 1.0, bounds = { duration = [0.1, 20.0] } }
search = { duration = [0.05, 5.0] }

[robot]
model = "ur5"
payload = { mass = 1.0 }
friction = { viscous = 0.1 }
motor = { torque_constant = 1.0, resistance = 1.0 }

[limits]
acceleration = 5.0
gaps = [{ gap = 1, velocity = 0.5 }]
cartesian_speed = [{ frame = "tool0", speed = 1.0 }]
"""


def test_every_key_of_a_case_is_on_the_page_of_the_case_file(monkeypatch) -> None:
    from ocp_traj.case import load_case_text
    from ocp_traj.case.section import Section

    asked: set[str] = set()
    check = Section.check_keys

    def listen(section: Section, known) -> None:
        asked.update(known)
        check(section, known)

    monkeypatch.setattr(Section, "check_keys", listen)
    load_case_text(EVERY_TABLE)
    page = (ROOT / "docs" / "case-file.md").read_text(encoding="utf-8")
    assert {
        "schema",
        "lock",
        "inertia",
        "coulomb",
        "gear_ratio",
        "moveit",
        "gap_durations",
        "protocol",
    } <= asked
    assert not {key for key in asked if not re.search(rf"\b{key}\b", page)}


DOCTESTED = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for package in ("ocp_traj", "metaheuristics")
    for path in (ROOT / package).rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("module", DOCTESTED)
def test_the_examples_in_docstrings_print_what_they_show(module: str) -> None:
    outcome = doctest.testmod(importlib.import_module(module), optionflags=doctest.ELLIPSIS)
    assert outcome.attempted > 0
    assert outcome.failed == 0


def test_the_check_of_links_finds_missing_files_and_missing_places(tmp_path: Path) -> None:
    broken_links = runpy.run_path(str(ROOT / "docs" / "check_links.py"))["broken_links"]
    (tmp_path / "sub").mkdir()
    (tmp_path / "one.html").write_text(
        '<h1 id="top-of-one">1</h1><a href="sub/two.html#there">good</a><a href="https://example.org/x">far</a>'
    )
    two = '<p id="there">2</p><a href="../one.html#top-of-one">good</a><a href="#there">good</a>'
    (tmp_path / "sub" / "two.html").write_text(two)
    assert broken_links(tmp_path) == []
    (tmp_path / "sub" / "two.html").write_text('<a href="../one.html#nowhere">1</a><img src="none.png">')
    assert broken_links(tmp_path) == [
        "one.html: sub/two.html#there is no place on that page",
        "sub/two.html: ../one.html#nowhere is no place on that page",
        "sub/two.html: none.png is no file",
    ]


def test_every_example_says_what_its_result_should_be_close_to() -> None:
    for path in sorted((ROOT / "examples").rglob("*.py")):
        assert "should be" in path.read_text(encoding="utf-8"), path.name
