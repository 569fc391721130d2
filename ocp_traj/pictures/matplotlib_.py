"""Draw pictures with Matplotlib, for publications: PDF, PNG or SVG by the file's ending."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ocp_traj.exceptions import InputError
from ocp_traj.pictures.picture import LIMIT, Line, Panel, Picture

FORMATS = (".pdf", ".png", ".svg")

_COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#c0569a", "#c98a00", "#7a5195", "#8c6d31", "#3b9fd8", "#444c54", "#b3003b",
)  # fmt: skip

_STYLE: Any = {
    "font.size": 8.0,
    "axes.titlesize": 9.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.alpha": 0.3,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
}


PRINT_DPI = 200
"""Dots per inch of a PNG that is to be printed."""


def save_picture(picture: Picture, path: Path, dpi: int = PRINT_DPI) -> None:
    """Write a picture to a file, a PNG with `dpi` dots per inch.

    Raises
    ------
    InputError
        The file's ending is none of ``.pdf``, ``.png``, ``.svg``, or the file cannot be written.
    """
    save_figure(lambda: _draw(picture), path, dpi)


def save_figure(make: Callable[[], Any], path: Path, dpi: int = PRINT_DPI) -> None:
    """Write the Matplotlib figure that `make` returns, in the style of all pictures; raises as `save_picture`."""
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path} ends in {path.suffix!r}, expected one of {', '.join(FORMATS)}")
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        figure = make()
        try:
            figure.savefig(path, dpi=dpi)
        except OSError as error:
            raise InputError(f"cannot write {path}: {error.strerror or error}") from None


def _draw(picture: Picture) -> Any:
    from matplotlib.figure import Figure

    columns = min(picture.columns, len(picture.panels))
    rows = -(-len(picture.panels) // columns)
    heights = [_height(picture.panels[row * columns : (row + 1) * columns]) for row in range(rows)]
    across = _legend_columns(list(picture.legend), 3.5 * columns)
    below = 0.3 + 0.2 * -(-len(picture.legend) // across)
    figure = Figure(figsize=(3.5 * columns, sum(heights) + below), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False, height_ratios=heights)
    for place, axes in enumerate(grid.flat):
        if place < len(picture.panels):
            _draw_panel(axes, picture.panels[place])
        else:
            axes.set_axis_off()
    handles = [_plot(grid.flat[0], line, empty=True) for line in picture.legend.values()]
    if handles:
        figure.legend(
            handles,
            list(picture.legend),
            loc="outside lower center",
            ncols=across,
            frameon=False,
        )
    return figure


def _height(panels: Sequence[Panel]) -> float:
    """Return the height of a row of panels, inches: named rows need room for their names."""
    return max(2.4, *(0.6 + 0.25 * len(panel.row_names) for panel in panels))


def _legend_columns(labels: list[str], inches: float) -> int:
    """Return how many entries of a legend fit side by side."""
    widest = max((len(label) for label in labels), default=0)
    return max(1, min(max(len(labels), 1), int(inches / (0.6 + 0.065 * widest))))


def _draw_panel(axes: Any, panel: Panel) -> None:
    for band in panel.bands:
        axes.fill_between(
            band.x, band.lower, band.upper, color=_COLOURS[band.colour % len(_COLOURS)], alpha=0.2, lw=0
        )
    for line in panel.lines:
        _plot(axes, line)
    axes.set(title=panel.title, xlabel=panel.x_label, ylabel=panel.y_label)
    if panel.log_x:
        axes.set_xscale("log")
    if panel.log_y:
        axes.set_yscale("log")
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim")
    if panel.y_range:
        axes.set_ylim(*panel.y_range)
    if panel.row_names:
        axes.set_yticks([])
        for row, name in enumerate(panel.row_names):
            place = {"xycoords": axes.get_yaxis_transform(), "fontsize": 7}
            halo = {"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.4}
            axes.annotate(name, (0.02, row + 0.12), **place, bbox=halo)


def _plot(axes: Any, line: Line, empty: bool = False) -> Any:
    colour = "#888888" if line.colour == LIMIT else _COLOURS[line.colour % len(_COLOURS)]
    x, y = ([], []) if empty else (line.x, line.y)
    style = "--" if line.dashed else "-"
    drawn = "steps-post" if line.step else "default"
    return axes.plot(
        x, y, color=colour, linestyle=style, drawstyle=drawn, linewidth=2.8 if line.wide else 1.1
    )[0]
