"""A user's own CasADi function of (q, v, a, tau), made ready for numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError

_BLOCK = 256
"""Columns that one call of a mapped function takes: several times faster than as many columns of a plain one."""


def numeric_function(function: Any, n: int) -> Callable[[Array, Array, Array, Array], Array]:
    """Return (q, v, a, tau), each (N, n), to values (N, k).

    Parameters
    ----------
    function : casadi.Function or callable
        Takes four CasADi columns (n,) and returns a column of k.

    Raises
    ------
    InputError
        The function does not take four columns of n.
    """
    import casadi as ca

    symbols = [ca.MX.sym(name, n) for name in ("q", "v", "a", "tau")]
    try:
        value = function(*symbols)
        column = ca.vertcat(*value) if isinstance(value, (list, tuple)) else ca.vec(value)
        compiled = ca.Function("custom", symbols, [column])
    except (RuntimeError, NotImplementedError, TypeError, ValueError) as error:
        raise InputError(
            f"a custom function cannot be called with q, v, a, tau of {n} joints: {error}"
        ) from error

    blocks = compiled.map(_BLOCK)

    def evaluate(q: Array, v: Array, a: Array, tau: Array) -> Array:
        columns = [array.T for array in (q, v, a, tau)]
        found = []
        for start in range(0, q.shape[0], _BLOCK):
            part = [array[:, start : start + _BLOCK] for array in columns]
            found.append(np.array((blocks if part[0].shape[1] == _BLOCK else compiled)(*part)))
        values: Array = np.concatenate(found, axis=1).T
        return values

    return evaluate
