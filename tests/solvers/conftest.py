"""Makes the entry points of the source tree visible."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

GROUP = "ocp_traj.solvers"


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Return a function that puts a package's metadata and modules on the search path, as pip would."""

    def put(name: str, entry_points: dict[str, str], modules: dict[str, str] | None = None) -> None:
        folder = tmp_path / f"{name}-1.0.dist-info"
        folder.mkdir()
        (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        lines = [f"{key} = {value}" for key, value in entry_points.items()]
        (folder / "entry_points.txt").write_text("\n".join([f"[{GROUP}]", *lines, ""]))
        for module, text in (modules or {}).items():
            (tmp_path / f"{module}.py").write_text(text)
        monkeypatch.syspath_prepend(str(tmp_path))

    return put


@pytest.fixture
def own_entry_points(install: Callable[..., None]) -> dict[str, str]:
    """Return the entry points pyproject.toml declares, visible whether the package is installed or not."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    text = (Path(__file__).parents[2] / "pyproject.toml").read_text()
    declared: dict[str, str] = tomllib.loads(text)["project"]["entry-points"][GROUP]
    install("ocp_traj_source_tree", declared)
    return declared
