"""The direction of imports: imports lead downwards, and third parties stay behind their fences."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

PICTURE = ROOT / "docs" / "design.md"

ROW = re.compile(r"^\| (\d+) \| ((?:`\w+`(?:, )?)+) \|$", re.MULTILINE)
"""A row of the table of layers: its number, and the parts it holds."""


def drawn_layers() -> dict[str, int]:
    """Return the layer of every part of ocp_traj as the design page draws it; one imports from its own and below."""
    rows = ROW.findall(PICTURE.read_text(encoding="utf-8"))
    return {part: int(layer) for layer, parts in rows for part in re.findall(r"\w+", parts)}


LAYERS = drawn_layers()

BUILDERS = ("codegen", "robot", "spline", "instant", "limits", "costs", "transcription", "solvers")
"""Where CasADi symbols are built or solved."""

FENCES = {
    "pinocchio": ("robot",),
    "casadi": (*BUILDERS, "audit", "references"),  # the judge evaluates a user's own CasADi constraint
    "toppra": ("references",),
    "cvxpy": ("references",),
    "clarabel": ("references",),
    "pandas": ("comparison",),
    "matplotlib": ("pictures",),
    "coal": ("collision",),
    "tomllib": ("case",),
    "tomli": ("case",),
    "tomli_w": ("case",),
    "click": ("cli",),
    "sqlite3": ("comparison",),
}
"""Third-party modules and the only parts that import them."""


def modules(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


def dotted(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def part_of(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


def nodes_of(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes, those that only a type checker reads among them."""
    for node in ast.iter_child_nodes(tree):
        yield node
        yield from nodes_of(node)


def imported(path: Path) -> set[str]:
    """Return the modules a file imports, wherever in the file, for a type checker or when it runs."""
    names: set[str] = set()
    for node in nodes_of(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0 and node.module, f"{path} imports by dots"
            names.update(full_names(node.module, [alias.name for alias in node.names]))
    return names


def full_names(module: str, names: list[str]) -> set[str]:
    """Return what ``from module import names`` loads: submodules where there are such, else the module."""
    folder = ROOT.joinpath(*module.split("."))
    submodules = {f"{module}.{name}" for name in names if (folder / f"{name}.py").is_file()}
    return submodules if len(submodules) == len(names) else submodules | {module}


def test_the_picture_of_the_house_shows_every_part_and_no_other() -> None:
    parts = {part_of(dotted(path)) for path in modules("ocp_traj")} - {""}
    assert set(LAYERS) == parts


@pytest.mark.parametrize("path", modules("ocp_traj"), ids=dotted)
def test_a_module_imports_only_from_its_own_layer_and_below(path: Path) -> None:
    part = part_of(dotted(path))
    if not part:
        return  # the package itself names every part, and imports none until it is asked
    assert part in LAYERS, f"give {part} a layer"
    for name in imported(path):
        if name.startswith("ocp_traj.") and name != "ocp_traj":
            other = part_of(name)
            assert other in LAYERS, f"give {other} a layer"
            assert LAYERS[other] <= LAYERS[part], f"{dotted(path)} imports {name}, which lies above it"


@pytest.mark.parametrize("path", modules("ocp_traj"), ids=dotted)
def test_third_parties_stay_behind_their_fences(path: Path) -> None:
    part = part_of(dotted(path))
    for name in {entry.split(".")[0] for entry in imported(path)} & set(FENCES):
        assert part in FENCES[name], f"{dotted(path)} imports {name}, fenced in {FENCES[name]}"


@pytest.mark.parametrize("path", modules("metaheuristics"), ids=dotted)
def test_metaheuristics_needs_numpy_only(path: Path) -> None:
    allowed = {"numpy", "metaheuristics"} | set(sys.stdlib_module_names)
    assert {name.split(".")[0] for name in imported(path)} <= allowed


@pytest.mark.parametrize("package", ["ocp_traj", "metaheuristics"])
def test_no_import_leads_back_to_where_it_came_from(package: str) -> None:
    paths = {dotted(path): path for path in modules(package)}
    graph = {name: imported(path) & set(paths) - {name, package} for name, path in paths.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"import cycle: {' -> '.join(error.args[1])}")


def test_importing_the_packages_loads_nothing_heavy() -> None:
    heavy = ["numpy", "scipy", "casadi", "pinocchio", "matplotlib", "pandas", "toppra", "rich", "click"]
    code = f"import sys, ocp_traj; print([name for name in {heavy} if name in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert run.stdout.strip() == "[]"


def test_every_public_name_can_be_imported_and_a_wrong_one_says_so() -> None:
    import ocp_traj

    for name in ocp_traj.__all__:
        assert getattr(ocp_traj, name) is not None
    assert set(dir(ocp_traj)) == set(ocp_traj.__all__)
    with pytest.raises(AttributeError, match="module 'ocp_traj' has no attribute 'nothing'"):
        ocp_traj.nothing
