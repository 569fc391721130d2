"""A user's own CasADi function of (q, v, a, tau), made ready for numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError


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

    def evaluate(q: Array, v: Array, a: Array, tau: Array) -> Array:
        return np.array(compiled(q.T, v.T, a.T, tau.T)).T

    return evaluate
