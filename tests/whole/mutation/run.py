"""Mutation testing: change one thing in one module, run the tests that should notice, count those that do not.

    python tests/whole/mutation/run.py audit --sample 80 --seed 0
    python tests/whole/mutation/run.py metaheuristics --sample 80 --seed 0 --output survivors.json

Each mutant is compiled in a forked child and given to the import system there: no file is ever changed. A mutant
is killed by a failing test, by an error at import, or by using far more processor time than the tests do.
"""

from __future__ import annotations

import argparse
import ast
import importlib.machinery
import importlib.util
import json
import os
import random
import resource
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from areas import AREAS, ROOT

COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
OPERATORS: dict[type[ast.operator], tuple[type[ast.operator], ...]] = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.FloorDiv: (ast.Mult,),
    ast.Mod: (ast.Add,),
    ast.Pow: (ast.Mult,),
    ast.BitAnd: (ast.BitOr,),
    ast.BitOr: (ast.BitAnd,),
}
NAMES = {"min": "max", "minimum": "maximum", "any": "all", "argmin": "argmax", "zeros": "ones", "sin": "cos"}
NAMES |= {new: old for old, new in NAMES.items()}
NAMES |= {"abs": "negative", "isfinite": "isnan", "standard_normal": "random", "exp": "log1p"}


@dataclass(frozen=True)
class Mutant:
    """One change: the `index`-th site of a module."""

    path: str
    index: int
    line: int
    change: str


def sites(tree: ast.Module) -> Iterator[tuple[int, str, Callable[[], None]]]:
    """Yield (line, change, apply) for everything that can be changed; annotations and texts are left alone."""
    for node in walk(tree):
        line = getattr(node, "lineno", 0)
        for change, apply in changes(node):
            yield line, f"{change} in `{ast.unparse(node).splitlines()[0][:90]}`", apply


def walk(node: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes but annotations, decorators and imports."""
    yield node
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not isinstance(child, (ast.Import, ast.ImportFrom)):
                yield from walk(child)


def changes(node: ast.AST) -> Iterator[tuple[str, Callable[[], None]]]:
    """Yield what can be changed in one node."""

    def setter(field: str, value: Any) -> Callable[[], None]:
        return lambda: setattr(node, field, value)

    if isinstance(node, ast.Compare):
        for place, operator in enumerate(node.ops):
            for new in COMPARISONS[type(operator)]:
                ops = [*node.ops[:place], new(), *node.ops[place + 1 :]]
                yield f"{type(operator).__name__} -> {new.__name__}", setter("ops", ops)
    elif isinstance(node, (ast.BinOp, ast.AugAssign)):
        for other in OPERATORS.get(type(node.op), ()):
            yield f"{type(node.op).__name__} -> {other.__name__}", setter("op", other())
    elif isinstance(node, ast.BoolOp):
        swapped = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield f"{type(node.op).__name__} -> {type(swapped).__name__}", setter("op", swapped)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not, ast.Invert)):
        kept = ast.UAdd() if isinstance(node.op, (ast.USub, ast.Invert)) else ast.Not()
        if isinstance(node.op, ast.Not):
            yield "Not removed", setter("operand", ast.UnaryOp(kept, node.operand))
        else:
            yield f"{type(node.op).__name__} removed", setter("op", kept)
    elif isinstance(node, (ast.If, ast.IfExp, ast.While)):
        yield "condition negated", setter("test", ast.UnaryOp(ast.Not(), node.test))
    elif isinstance(node, ast.Constant) and isinstance(node.value, (bool, int, float)):
        value = node.value
        new = (
            (not value)
            if isinstance(value, bool)
            else value + 1
            if isinstance(value, int)
            else 2 * value or 1.0
        )
        yield f"{value!r} -> {new!r}", setter("value", new)
    elif isinstance(node, ast.Attribute) and node.attr in NAMES:
        yield f"{node.attr} -> {NAMES[node.attr]}", setter("attr", NAMES[node.attr])
    elif isinstance(node, ast.Name) and node.id in ("min", "max", "any", "all"):
        yield f"{node.id} -> {NAMES[node.id]}", setter("id", NAMES[node.id])


def find_mutants(path: str) -> list[Mutant]:
    """Return all mutants of one module."""
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    return [Mutant(path, index, line, change) for index, (line, change, _) in enumerate(sites(tree))]


class MutantLoader(importlib.machinery.SourceFileLoader):
    """Loads one module with one change."""

    def __init__(self, name: str, mutant: Mutant) -> None:
        super().__init__(name, str(ROOT / mutant.path))
        self.mutant = mutant

    def get_code(self, fullname: str) -> Any:
        """Return the changed code."""
        tree = ast.parse(Path(self.path).read_text(encoding="utf-8"))
        for index, (_, _, apply) in enumerate(sites(tree)):
            if index == self.mutant.index:
                apply()
                break
        return compile(ast.fix_missing_locations(tree), self.path, "exec")


class MutantFinder:
    """Gives the import system the changed module."""

    def __init__(self, mutant: Mutant) -> None:
        self.mutant = mutant
        self.name = mutant.path.removesuffix(".py").replace("/", ".")

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:
        """Return the module's spec if it is the changed one."""
        if fullname != self.name:
            return None
        return importlib.util.spec_from_loader(fullname, MutantLoader(fullname, self.mutant))


def run_tests(tests: list[str], mutant: Mutant | None, seconds: float) -> tuple[bool, str]:
    """Run tests in a forked child; return whether all passed, and the first that did not."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.close(read)
            status = run_child(tests, mutant, seconds, write)
        finally:
            os._exit(status)
    os.close(write)
    with os.fdopen(read) as stream:
        first = stream.readline().strip()
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return False, f"signal {os.WTERMSIG(status)} (processor time)"
    return os.WEXITSTATUS(status) == 0, first


def run_child(tests: list[str], mutant: Mutant | None, seconds: float, write: int) -> int:
    """Run pytest with the change in place; return its exit status."""
    import pytest

    class FirstFailure:
        def pytest_runtest_logreport(self, report: Any) -> None:
            if report.failed:
                os.write(write, (report.nodeid + "\n").encode())

        def pytest_collectreport(self, report: Any) -> None:
            if report.failed:
                os.write(write, b"at import\n")

    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 1))
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    if mutant is not None:
        sys.meta_path.insert(0, MutantFinder(mutant))
    plain = ["--override-ini", "addopts=", "--import-mode=importlib", "-m", "not slow and not long"]
    arguments = ["-x", "-q", "-p", "no:cacheprovider", "--rootdir", str(ROOT), *plain, *tests]
    return int(pytest.main(arguments, plugins=[FirstFailure()]))


def preload(area: str) -> None:
    """Import what no mutant touches, once, before children are forked."""
    from _pytest.config import default_plugins

    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    names = ["hypothesis", "numpy", "scipy.stats", "scipy.optimize", "scipy.interpolate", "pytest"]
    names += [f"_pytest.{name}" for name in default_plugins]
    if area != "metaheuristics":
        names += ["casadi", "pinocchio", "ocp_traj.robot.inverse_dynamics", "ocp_traj.robot.urdf"]
        names += ["ocp_traj.robot.robot", "ocp_traj.robot.packaged", "ocp_traj.trajectory"]
    if area == "audit":
        names.append("ocp_traj.task")
    for name in names:
        importlib.import_module(name)
    early = {path.removesuffix(".py").replace("/", ".") for path in AREAS[area]} & set(sys.modules)
    if early:
        raise RuntimeError(f"{', '.join(sorted(early))} imported before it can be changed")


def main() -> int:
    """Draw mutants, run them, tell which survived."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("area", choices=AREAS)
    parser.add_argument("--sample", type=int, default=80, help="number of mutants (0: all)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=120.0, help="processor time a mutant may take")
    parser.add_argument("--modules", nargs="*", default=[], metavar="NAME", help="just these modules")
    parser.add_argument("--only", nargs="*", default=[], metavar="PATH:INDEX", help="just these mutants")
    parser.add_argument("--list", action="store_true", help="tell how many mutants there are and stop")
    parser.add_argument(
        "--output", type=Path, help="JSON file for the results; what it holds is not run again"
    )
    options = parser.parse_args()
    os.chdir(ROOT)
    modules = {
        path: tests
        for path, tests in AREAS[options.area].items()
        if not options.modules or Path(path).stem in options.modules
    }
    everything = [mutant for path in modules for mutant in find_mutants(path)]
    if options.list:
        for path, count in Counter(mutant.path for mutant in everything).items():
            print(f"{count:5d}  {path}")
        return 0
    chosen = [mutant for mutant in everything if f"{mutant.path}:{mutant.index}" in options.only]
    if not options.only:
        count = min(options.sample or len(everything), len(everything))
        chosen = random.Random(options.seed).sample(everything, len(everything))[:count]
    return report(chosen, everything, modules, options)


def report(
    chosen: list[Mutant], everything: list[Mutant], modules: dict[str, tuple[str, ...]], options: Any
) -> int:
    """Run the chosen mutants and print every survivor and the counts."""
    preload(options.area)
    for names in set(modules.values()):
        passed, first = run_tests(list(names), None, 10 * options.seconds)
        if not passed:
            print(f"the tests fail without any change: {first}")
            return 2
    results = json.loads(options.output.read_text()) if options.output and options.output.exists() else []
    known = {(result["path"], result["index"], result["change"]) for result in results}
    chosen = [mutant for mutant in chosen if (mutant.path, mutant.index, mutant.change) not in known]
    with ThreadPoolExecutor(options.jobs) as pool:
        outcomes = pool.map(lambda mutant: run_tests(list(modules[mutant.path]), mutant, options.seconds), chosen)
        for mutant, (survived, first) in zip(chosen, outcomes, strict=True):
            results.append({**asdict(mutant), "survived": survived, "killed_by": first})
            if survived:
                print(f"SURVIVED {mutant.path}:{mutant.line} [{mutant.index}] {mutant.change}", flush=True)
            if options.output:
                options.output.write_text(json.dumps(results, indent=1))
    left = sum(result["survived"] for result in results)
    print(f"{len(results)} of {len(everything)} mutants: {len(results) - left} killed, {left} survived")
    return 0


if __name__ == "__main__":
    sys.exit(main())
