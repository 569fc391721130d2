"""The constrained classics g01 to g13 with their best known solutions.

As collected by Runarsson & Yao 2000, doi 10.1109/4235.873238 (Michalewicz & Schoenauer 1996); all as
minimisation, constraints as g(x) <= 0 and |h(x)| <= 1e-4, and their violation in their own unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from metaheuristics.arrays import FloatArray, freeze
from metaheuristics.evaluation import Evaluation
from metaheuristics.problem import Problem

EQUALITY_TOLERANCE = 1e-4
"""An equality h(x) = 0 counts as kept within this, as in the source."""

Values = list[FloatArray]
Formula = Callable[[Values], tuple[FloatArray, Values, Values]]


@dataclass(frozen=True)
class Classic:
    """One of the classics.

    Parameters
    ----------
    formula
        Takes the variables x_1 ... x_d, (p,) each; returns cost, inequalities g and equalities h, (p,) each.
    lower, upper
        The box.
    optimum
        Best known x.
    best_cost
        Best known cost.
    """

    formula: Formula
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    optimum: tuple[float, ...]
    best_cost: float


class ConstrainedProblem(Problem):
    """One of g01 to g13.

    Parameters
    ----------
    name
        ``"g01"`` to ``"g13"``.

    Raises
    ------
    ValueError
        If there is no such problem.
    """

    def __init__(self, name: str) -> None:
        if name not in CLASSICS:
            raise ValueError(f"The constrained problem is {name!r}, expected g01 to g13.")
        self._classic = CLASSICS[name]
        super().__init__(name, self._classic.lower, self._classic.upper)
        self.optimum = freeze(self._classic.optimum)
        self.best_cost = self._classic.best_cost

    def evaluate(self, X: FloatArray) -> Evaluation:
        """Return costs and violations of X (p, d); see `Problem.evaluate`."""
        cost, inequalities, equalities = self._classic.formula(list(X.T))
        rows = [np.maximum(g, 0.0) for g in inequalities]
        rows += [np.maximum(np.abs(h) - EQUALITY_TOLERANCE, 0.0) for h in equalities]
        return Evaluation(cost, np.stack(rows, axis=1))


def _g01(x: Values) -> tuple[FloatArray, Values, Values]:
    cost = 5.0 * sum(x[:4]) - 5.0 * sum(v * v for v in x[:4]) - sum(x[4:])
    g = [2 * x[0] + 2 * x[1] + x[9] + x[10] - 10, 2 * x[0] + 2 * x[2] + x[9] + x[11] - 10]
    g += [2 * x[1] + 2 * x[2] + x[10] + x[11] - 10]
    g += [-8 * x[0] + x[9], -8 * x[1] + x[10], -8 * x[2] + x[11]]
    g += [-2 * x[3] - x[4] + x[9], -2 * x[5] - x[6] + x[10], -2 * x[7] - x[8] + x[11]]
    return np.asarray(cost), g, []


def _g02(x: Values) -> tuple[FloatArray, Values, Values]:
    z = np.stack(x)
    ranks = np.arange(1.0, len(x) + 1.0)[:, None]
    bumps = (np.cos(z) ** 4).sum(axis=0) - 2.0 * (np.cos(z) ** 2).prod(axis=0)
    length = np.sqrt((ranks * z * z).sum(axis=0))
    cost = -np.abs(np.divide(bumps, length, out=np.zeros_like(bumps), where=length > 0.0))
    return cost, [0.75 - z.prod(axis=0), z.sum(axis=0) - 7.5 * len(x)], []


def _g03(x: Values) -> tuple[FloatArray, Values, Values]:
    z = np.stack(x)
    return -(math.sqrt(len(x)) ** len(x)) * z.prod(axis=0), [], [(z * z).sum(axis=0) - 1.0]


def _g04(x: Values) -> tuple[FloatArray, Values, Values]:
    a, b, c, d, e = x
    u = 85.334407 + 0.0056858 * b * e + 0.0006262 * a * d - 0.0022053 * c * e
    s = 80.51249 + 0.0071317 * b * e + 0.0029955 * a * b + 0.0021813 * c * c
    w = 9.300961 + 0.0047026 * c * e + 0.0012547 * a * c + 0.0019085 * c * d
    cost = 5.3578547 * c * c + 0.8356891 * a * e + 37.293239 * a - 40792.141
    return cost, [u - 92, -u, s - 110, 90 - s, w - 25, 20 - w], []


def _g05(x: Values) -> tuple[FloatArray, Values, Values]:
    a, b, c, d = x
    cost = 3 * a + 1e-6 * a**3 + 2 * b + 2e-6 / 3 * b**3
    h = [
        1000 * np.sin(-c - 0.25) + 1000 * np.sin(-d - 0.25) + 894.8 - a,
        1000 * np.sin(c - 0.25) + 1000 * np.sin(c - d - 0.25) + 894.8 - b,
        1000 * np.sin(d - 0.25) + 1000 * np.sin(d - c - 0.25) + 1294.8,
    ]
    return cost, [c - d - 0.55, d - c - 0.55], h


def _g06(x: Values) -> tuple[FloatArray, Values, Values]:
    a, b = x
    g = [100 - (a - 5) ** 2 - (b - 5) ** 2, (a - 6) ** 2 + (b - 5) ** 2 - 82.81]
    return (a - 10) ** 3 + (b - 20) ** 3, g, []


def _g07(x: Values) -> tuple[FloatArray, Values, Values]:
    a, b, c, d, e, f, g, h, i, j = x
    cost = a * a + b * b + a * b - 14 * a - 16 * b + (c - 10) ** 2 + 4 * (d - 5) ** 2 + (e - 3) ** 2
    cost = cost + 2 * (f - 1) ** 2 + 5 * g * g + 7 * (h - 11) ** 2 + 2 * (i - 10) ** 2 + (j - 7) ** 2 + 45
    rows = [
        -105 + 4 * a + 5 * b - 3 * g + 9 * h,
        10 * a - 8 * b - 17 * g + 2 * h,
        -8 * a + 2 * b + 5 * i - 2 * j - 12,
        3 * (a - 2) ** 2 + 4 * (b - 3) ** 2 + 2 * c * c - 7 * d - 120,
        5 * a * a + 8 * b + (c - 6) ** 2 - 2 * d - 40,
        a * a + 2 * (b - 2) ** 2 - 2 * a * b + 14 * e - 6 * f,
        0.5 * (a - 8) ** 2 + 2 * (b - 4) ** 2 + 3 * e * e - f - 30,
        -3 * a + 6 * b + 12 * (i - 8) ** 2 - 7 * j,
    ]
    return cost, rows, []


def _g08(x: Values) -> tuple[FloatArray, Values, Values]:
    a, b = x
    top, bottom = np.sin(2 * math.pi * a) ** 3 * np.sin(2 * math.pi * b), a**3 * (a + b)
    cost = -np.divide(top, bottom, out=np.zeros_like(top), where=bottom > 0.0)
    return cost, [a * a - b + 1, 1 - a + (b - 4) ** 2], []


def _g09(x: Values) -> tuple[FloatArray, Values, Values]:
    a, b, c, d, e, f, g = x
    cost = (a - 10) ** 2 + 5 * (b - 12) ** 2 + c**4 + 3 * (d - 11) ** 2 + 10 * e**6
    cost = cost + 7 * f * f + g**4 - 4 * f * g - 10 * f - 8 * g
    rows = [
        -127 + 2 * a * a + 3 * b**4 + c + 4 * d * d + 5 * e,
        -282 + 7 * a + 3 * b + 10 * c * c + d - e,
        -196 + 23 * a + b * b + 6 * f * f - 8 * g,
        4 * a * a + b * b - 3 * a * b + 2 * c * c + 5 * f - 11 * g,
    ]
    return cost, rows, []


def _g10(x: Values) -> tuple[FloatArray, Values, Values]:
    a, b, c, d, e, f, g, h = x
    rows = [
        -1 + 0.0025 * (d + f),
        -1 + 0.0025 * (e + g - d),
        -1 + 0.01 * (h - e),
        -a * f + 833.33252 * d + 100 * a - 83333.333,
        -b * g + 1250 * e + b * d - 1250 * d,
        -c * h + 1250000 + c * e - 2500 * e,
    ]
    return a + b + c, rows, []


def _g11(x: Values) -> tuple[FloatArray, Values, Values]:
    a, b = x
    return a * a + (b - 1) ** 2, [], [b - a * a]


def _g12(x: Values) -> tuple[FloatArray, Values, Values]:
    # The feasible set is the union of 9^3 balls; the nearest centre is found coordinate by coordinate.
    distance = sum((v - np.clip(np.round(v), 1.0, 9.0)) ** 2 for v in x)
    cost = -(100.0 - sum((v - 5.0) ** 2 for v in x)) / 100.0
    return np.asarray(cost), [np.asarray(distance) - 0.0625], []


def _g13(x: Values) -> tuple[FloatArray, Values, Values]:
    a, b, c, d, e = x
    h = [a * a + b * b + c * c + d * d + e * e - 10, b * c - 5 * d * e, a**3 + b**3 + 1]
    return np.exp(a * b * c * d * e), [], h


CLASSICS: dict[str, Classic] = {
    "g01": Classic(
        _g01,
        (0.0,) * 13,
        (1.0,) * 9 + (100.0,) * 3 + (1.0,),
        (1.0,) * 9 + (3.0,) * 3 + (1.0,),
        -15.0,
    ),
    "g02": Classic(
        _g02,
        (0.0,) * 20,
        (10.0,) * 20,
        (
            3.16246061572185, 3.12833142812967, 3.09479212988791, 3.06145059523469, 3.02792915885555,
            2.99382606701730, 2.95866871765285, 2.92184227312450, 0.49482511456933, 0.48835711005490,
            0.48231642711865, 0.47664475092742, 0.47129550835493, 0.46623099264167, 0.46142004984199,
            0.45683664767217, 0.45245876903267, 0.44826762241853, 0.44424700958760, 0.44038285956317,
        ),
        -0.80361910412559,
    ),
    "g03": Classic(_g03, (0.0,) * 10, (1.0,) * 10, (1.0 / math.sqrt(10.0),) * 10, -1.0),
    "g04": Classic(
        _g04,
        (78.0, 33.0, 27.0, 27.0, 27.0),
        (102.0, 45.0, 45.0, 45.0, 45.0),
        (78.0, 33.0, 29.9952560256815985, 45.0, 36.7758129057882073),
        -30665.53867178332,
    ),
    "g05": Classic(
        _g05,
        (0.0, 0.0, -0.55, -0.55),
        (1200.0, 1200.0, 0.55, 0.55),
        (679.945148297028709, 1026.06697600004691, 0.118876369094410433, -0.39623348521517826),
        5126.4967140071,
    ),
    "g06": Classic(
        _g06, (13.0, 0.0), (100.0, 100.0), (14.09500000000000064, 0.8429607892154795668), -6961.81387558015
    ),
    "g07": Classic(
        _g07,
        (-10.0,) * 10,
        (10.0,) * 10,
        (
            2.17199634142692, 2.3636830416034, 8.77392573913157, 5.09598443745173, 0.990654756560493,
            1.43057392853463, 1.32164415364306, 9.82872576524495, 8.2800915887356, 8.3759266477347,
        ),
        24.30620906818,
    ),
    "g08": Classic(
        _g08, (0.0, 0.0), (10.0, 10.0), (1.22797135260752599, 4.24537336612274885), -0.0958250414180359
    ),
    "g09": Classic(
        _g09,
        (-10.0,) * 7,
        (10.0,) * 7,
        (
            2.33049935147405174, 1.95137236847114592, -0.477541399510615805, 4.36572624923625874,
            -0.624486959100388983, 1.03813099410962173, 1.5942266780671519,
        ),
        680.630057374402,
    ),
    "g10": Classic(
        _g10,
        (100.0, 1000.0, 1000.0) + (10.0,) * 5,
        (10000.0,) * 3 + (1000.0,) * 5,
        (
            579.306685017979589, 1359.97067807935605, 5109.97065743133317, 182.01769963061534,
            295.601173702746792, 217.982300369384632, 286.41652592786852, 395.601173702746735,
        ),
        7049.24802052867,
    ),
    "g11": Classic(_g11, (-1.0, -1.0), (1.0, 1.0), (-0.707036070037170616, 0.500000004333606807), 0.7499),
    "g12": Classic(_g12, (0.0,) * 3, (10.0,) * 3, (5.0,) * 3, -1.0),
    "g13": Classic(
        _g13,
        (-2.3, -2.3, -3.2, -3.2, -3.2),
        (2.3, 2.3, 3.2, 3.2, 3.2),
        (-1.71714224003, 1.59572124049468, 1.8272502406271, -0.763659881912867, -0.76365986736498),
        0.053941514041898,
    ),
}  # fmt: skip
"""The classics by name."""
