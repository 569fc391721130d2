"""Functions of one instant u = (q, v, a, jerk) with first and second derivatives, compiled where that can be.

They depend on the robot and on what is limited, not on the spline family or the waypoints, so one compiled library
serves every task of a robot.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca

from ocp_traj.transcription.lifted.elements import IndexArray, differentiate

WORTH_COMPILING = 300
"""Instructions from which a function is compiled rather than interpreted."""


@dataclass(frozen=True, eq=False)
class Outer:
    """A function c(u) of an instant with its sparse derivatives.

    Attributes
    ----------
    rows : int
        Number of values.
    functions : dict
        ``value`` u -> c, ``jacobian`` u -> nonzeros, ``hessian`` (u, multipliers) -> upper triangular nonzeros.
    jacobian_pattern, hessian_pattern : rows and columns of the nonzeros
    """

    rows: int
    functions: dict[str, Any]
    jacobian_pattern: tuple[IndexArray, IndexArray]
    hessian_pattern: tuple[IndexArray, IndexArray]


def outer_of(function: Any, *, needs_jerk: bool, total: bool, compiled: bool) -> Outer:
    """Return a function (q, v, a, jerk) -> values as an `Outer`.

    Parameters
    ----------
    function : casadi.Function
        Of four columns (n,).
    needs_jerk : bool
        Whether u holds the jerk; else it is zero.
    total : bool
        Take the sum of the values instead of the values.
    compiled : bool
        Use machine code where there is a C compiler; same results.
    """
    return _outer(function.serialize(), needs_jerk, total, compiled)


@lru_cache(maxsize=32)
def _outer(serialized: str, needs_jerk: bool, total: bool, compiled: bool) -> Outer:
    function = ca.Function.deserialize(serialized)
    n = function.numel_in(0)
    orders = 4 if needs_jerk else 3
    u = ca.SX.sym("u", orders * n)
    blocks = [u[k * n : (k + 1) * n] for k in range(orders)]
    if not needs_jerk:
        blocks.append(ca.SX.zeros(n))
    value = ca.densify(function(*blocks))
    if total:
        value = ca.sum1(value)
    functions, *patterns = differentiate("outer", value, [u])
    return Outer(value.numel(), _compile(functions) if compiled else functions, *patterns)


def _compile(functions: dict[str, Any]) -> dict[str, Any]:
    from ocp_traj.codegen.compiled import compile_function, find_compiler

    if find_compiler() is None or functions["hessian"].n_instructions() < WORTH_COMPILING:
        return functions
    with ThreadPoolExecutor() as pool:
        return dict(zip(functions, pool.map(compile_function, functions.values())))
