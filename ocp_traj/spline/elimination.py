"""Gaussian elimination of a sparse banded system whose entries are numbers, batches of numbers or symbols.

The same few lines solve one spline, a whole population of splines (entries of shape (P, 1), right-hand sides of
shape (P, n)) and the symbolic spline of a numerical problem (CasADi SX entries): that is how a family is defined
once and used by both transcriptions.
"""

from __future__ import annotations

from typing import Any

Row = dict[int, Any]


def solve_banded(rows: list[Row], right: list[Any]) -> list[Any]:
    """Solve ``A y = b`` without pivoting, in the given order.

    Parameters
    ----------
    rows : list of dict
        Row i holds its entries by column; the pivot of row i is column i. Spline systems keep their pivots away
        from zero in the order `ocp_traj.spline.interpolation` lists them.
    right : list
        Right-hand side of every row; anything that broadcasts with the entries.

    Returns
    -------
    list of the unknowns, of the type of the right-hand sides.
    """
    rows = [dict(row) for row in rows]
    right = list(right)
    size = len(rows)
    last_row = _last_rows(rows)
    for pivot in range(size):
        inverse = 1.0 / rows[pivot][pivot]
        for below in range(pivot + 1, last_row[pivot] + 1):
            entry = rows[below].pop(pivot, None)
            if entry is None:
                continue
            factor = entry * inverse
            for column, value in rows[pivot].items():
                if column > pivot:
                    change = factor * value
                    rows[below][column] = rows[below][column] - change if column in rows[below] else -change
            right[below] = right[below] - factor * right[pivot]
    return _substitute(rows, right)


def _last_rows(rows: list[Row]) -> list[int]:
    """Return the last row that elimination of each column can touch."""
    last = list(range(len(rows)))
    for index, row in enumerate(rows):
        for column in row:
            last[column] = max(last[column], index)
    for column in range(1, len(last)):
        last[column] = max(last[column], last[column - 1])
    return last


def _substitute(rows: list[Row], right: list[Any]) -> list[Any]:
    unknowns: list[Any] = [None] * len(rows)
    for pivot in reversed(range(len(rows))):
        value = right[pivot]
        for column, entry in rows[pivot].items():
            if column > pivot:
                value = value - entry * unknowns[column]
        unknowns[pivot] = value / rows[pivot][pivot]
    return unknowns
