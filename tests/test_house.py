"""The house keeps its size: folders and files that can be read in one sitting, and doors instead of windows."""

from __future__ import annotations

import ast
import statistics
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from helpers.folders import ROOT

PACKAGES = ("ocp_traj", "metaheuristics")

LARGEST_FOLDER = 16
"""Modules directly in one folder."""

LONGEST_FILE = 400
"""Lines."""

LONGER = {"ocp_traj/proofs/checker.py": 900}
"""Lines of files that have to be one: a proof is checked with a single file that needs nothing else."""

LARGEST_MEDIAN = 150
"""Lines of the median file of both packages."""

GUARD = "tests/helpers/bounds_guard.py"
"""It replaces the function inside the judge, so that modules that imported `audit` already are guarded, too."""


def files_of(*folders: str) -> list[Path]:
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


def short(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def lines_of(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def imports_of(tree: ast.Module) -> Iterator[tuple[str, str, str]]:
    """Yield (module, name, name in this file) of everything imported from one of our packages."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] in PACKAGES:
            yield from ((node.module, alias.name, alias.asname or alias.name) for alias in node.names)


def test_no_folder_holds_more_modules_than_one_takes_in_at_a_glance() -> None:
    counts = Counter(short(path.parent) for path in files_of(*PACKAGES, "tests"))
    assert {folder: count for folder, count in counts.items() if count > LARGEST_FOLDER} == {}


def test_no_file_is_longer_than_one_sitting() -> None:
    lengths = {short(path): lines_of(path) for path in files_of(*PACKAGES, "tests", "examples")}
    assert {
        path: lines for path, lines in lengths.items() if lines > LONGER.get(path, LONGEST_FILE)
    } == {}
    assert statistics.median(map(lines_of, files_of(*PACKAGES))) <= LARGEST_MEDIAN


def test_no_module_reaches_into_the_private_names_of_another_package() -> None:
    """A folder is a package; its own modules may share what begins with an underscore, others may not."""
    found = [
        f"{short(path)}: {module}.{name}"
        for path in files_of(*PACKAGES)
        for module, name, _ in imports_of(tree_of(path))
        if is_private(name) and (ROOT / Path(*module.split("."))).parent != path.parent
    ]
    assert found == []


@pytest.mark.parametrize("path", files_of("tests", "examples"), ids=short)
def test_tests_use_public_names_and_leave_the_search_path_alone(path: Path) -> None:
    tree = tree_of(path)
    ours = {name: f"{module}.{original}" for module, original, name in imports_of(tree)}
    private = [whole for whole in ours.values() if is_private(whole.rpartition(".")[2])]
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and is_private(node.attr) and isinstance(node.value, ast.Name):
            private += [f"{ours[node.value.id]}.{node.attr}"] if node.value.id in ours else []
        if isinstance(node, ast.Call) and ast.unparse(node.func).startswith("sys.path."):
            pytest.fail(f"{short(path)}, line {node.lineno}: {ast.unparse(node)}")
    assert private == [] or short(path) == GUARD, private
