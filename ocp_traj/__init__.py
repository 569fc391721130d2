"""Compare optimal-control solvers on robot-arm trajectories: one problem, one budget, one judge.

Public names are imported when first used, so ``import ocp_traj`` is light::

    import ocp_traj as ot

    task = ot.load_case("ur5-palletizing")
    result = ot.solve(task, "ipopt", seed=0)
"""

from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_HOME = {name: module for module, name in re.findall(r"^from (\S+) import (\w+)", _STUB, re.MULTILINE)}

__all__ = sorted(_HOME)


class _Package(ModuleType):
    """Keeps the module `audit`, once imported, from hiding the function of that name."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    """Import a public name from its module when it is first asked for."""
    if name not in _HOME:
        raise AttributeError(f"module 'ocp_traj' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    """Return the public names, for completion in an editor."""
    return __all__
