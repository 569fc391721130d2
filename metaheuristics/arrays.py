"""Array types and the copies that keep shared data read-only."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]


def freeze(values: npt.ArrayLike) -> FloatArray:
    """Return a read-only floating-point copy, so that no caller can change shared data.

    Parameters
    ----------
    values
        Anything NumPy reads as numbers, any shape.

    Returns
    -------
    FloatArray
        A contiguous copy with the write flag off.
    """
    copied = np.array(values, dtype=np.float64, order="C")
    copied.flags.writeable = False
    return copied


def read_only(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return a read-only view of an array nobody else writes to (no copy)."""
    view: npt.NDArray[Any] = values.view()
    view.flags.writeable = False
    return view
