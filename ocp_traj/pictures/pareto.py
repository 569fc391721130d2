"""The picture of a front: duration against a second objective, with its dominated and infeasible points."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.pictures.matplotlib_ import save_figure

if TYPE_CHECKING:
    from ocp_traj.pareto import ParetoFront

_FRONT, _OTHER, _BROKEN = "#0072b2", "#888888", "#d55e00"


def save_front(front: ParetoFront, path: Path) -> None:
    """Draw a front into a file.

    Raises
    ------
    InputError
        The file's ending is none of ``.pdf``, ``.png``, ``.svg``, or the file cannot be written.
    """
    from matplotlib.figure import Figure

    def make() -> Any:
        figure = Figure(figsize=(5.5, 3.5), layout="constrained")
        draw_front(figure.subplots(), front)
        return figure

    save_figure(make, path)


def draw_front(axes: Any, front: ParetoFront) -> None:
    """Draw a front into Matplotlib axes.

    The steps bound what the points found dominate. An infeasible motion is a cross where it lies; a point without a
    motion is a dotted line at the bound on its duration.
    """
    x, y = np.asarray(front.durations), np.asarray(front.values)
    on = np.flatnonzero(front.efficient)
    on = on[np.argsort(x[on])]
    axes.step(x[on], y[on], where="post", color=_FRONT, alpha=0.35, linewidth=1.0)
    axes.plot(x[on], y[on], "o", color=_FRONT, markersize=4.5, label="efficient")
    _mark(axes, x, y, front.feasible & front.dominated, "o", _OTHER, "dominated")
    _mark(axes, x, y, ~front.feasible & np.isfinite(x), "x", _BROKEN, "over a limit")
    lost = np.asarray(front.bounds)[~np.isfinite(x) & np.isfinite(front.bounds)]
    for index, bound in enumerate(lost):
        label = "no motion found" if index == 0 else None
        axes.axvline(bound, color=_BROKEN, linestyle=":", linewidth=1.0, label=label)
    axes.set_title(front.task.name)
    axes.set_xlabel("duration, s")
    axes.set_ylabel(f"{front.quantity.replace('_', ' ')}, {front.unit}")
    if len(on) < len(front.results):
        axes.legend(frameon=False)


def _mark(axes: Any, x: Any, y: Any, chosen: Any, marker: str, colour: str, label: str) -> None:
    if chosen.any():
        filled = "none" if marker == "o" else None
        axes.plot(
            x[chosen], y[chosen], marker, color=colour, markerfacecolor=filled, markersize=5.0, label=label
        )
