"""A generator that answers what a test wrote down, so that an update rule can be computed by hand."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
import pytest


class ScriptedGenerator:
    """Hands out prescribed numbers in the shapes asked for; an exhausted script fails the test."""

    def __init__(self, **scripts: list[Any]) -> None:
        self._scripts = {name: deque(values) for name, values in scripts.items()}

    def _next(self, name: str, shape: Any) -> Any:
        value = np.asarray(self._scripts[name].popleft(), dtype=np.float64)
        return float(value) if shape is None else np.broadcast_to(value, shape).copy()

    def random(self, size: Any = None, out: Any = None) -> Any:
        if out is not None:
            out[:] = self._next("random", out.shape)
            return out
        return self._next("random", size)

    def standard_normal(self, size: Any = None) -> Any:
        return self._next("standard_normal", size)

    def standard_cauchy(self, size: Any = None) -> Any:
        return self._next("standard_cauchy", size)

    def uniform(self, low: float, high: float, size: Any = None) -> Any:
        return self._next("uniform", size)

    @property
    def exhausted(self) -> bool:
        return not any(self._scripts.values())


@pytest.fixture
def scripted() -> type[ScriptedGenerator]:
    """Return the class: a test writes its numbers down as ``scripted(random=[...])``."""
    return ScriptedGenerator
