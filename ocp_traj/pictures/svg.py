"""Draw pictures as inline SVG that follows the page's colours, light or dark, and scales to a phone."""

from __future__ import annotations

from html import escape

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.pictures.axes import Axis, fit_axis
from ocp_traj.pictures.picture import LIMIT, Line, Panel, Picture

COLOURS = 10
"""Number of colours the page's style sheet defines (classes c0 to c9, and limit)."""

_WIDTH, _HEIGHT = 420.0, 280.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 58.0, 12.0, 26.0, 44.0


def draw_picture(picture: Picture) -> str:
    """Return an HTML figure with one SVG a panel, a legend and the caption."""
    panels = "".join(_draw_panel(panel) for panel in picture.panels)
    legend = "".join(
        f'<span class="key"><svg viewBox="0 0 24 8" width="24" height="8" aria-hidden="true">'
        f'<path class="{_style(line)}" d="M0 4H24"/></svg>{escape(label)}</span>'
        for label, line in picture.legend.items()
    )
    return (
        f'<figure class="picture"><div class="panels">{panels}</div>'
        f'<div class="legend">{legend}</div><figcaption>{escape(picture.caption)}</figcaption></figure>'
    )


def _draw_panel(panel: Panel) -> str:
    horizontal, vertical = _axes(panel)
    parts = [_grid(horizontal, vertical, not panel.row_names)]
    for band in panel.bands:
        parts.append(_band(horizontal, vertical, band.x, band.lower, band.upper, band.colour))
    for line in panel.lines:
        parts.append(_path(horizontal, vertical, line))
    for row, name in enumerate(panel.row_names):
        y = float(_screen(vertical, np.array(row + 0.12), True))
        parts.append(f'<text class="row" x="{_LEFT + 6}" y="{y:.1f}">{escape(name)}</text>')
    middle = _LEFT + (_WIDTH - _LEFT - _RIGHT) / 2
    labels = (
        f'<text class="title" x="{middle:.1f}" y="16">{escape(panel.title)}</text>'
        f'<text class="axis" x="{middle:.1f}" y="{_HEIGHT - 8:.1f}">{escape(panel.x_label)}</text>'
        f'<text class="axis" transform="translate(13 {(_TOP + _HEIGHT - _BOTTOM) / 2:.1f}) rotate(-90)">'
        f"{escape(panel.y_label)}</text>"
    )
    description = escape(f"{panel.title}: {panel.y_label} over {panel.x_label}")
    content = "".join(parts) + labels
    return f'<svg viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" role="img" aria-label="{description}">{content}</svg>'


def _axes(panel: Panel) -> tuple[Axis, Axis]:
    horizontal = fit_axis([line.x for line in panel.lines], panel.log_x, 0.0 if not panel.equal else 0.04)
    heights = [line.y for line in panel.lines]
    heights += [side for band in panel.bands for side in (band.lower, band.upper)]
    vertical = Axis(*panel.y_range) if panel.y_range else fit_axis(heights, panel.log_y)
    if panel.equal:
        return _equalise(horizontal, vertical)
    return horizontal, vertical


def _equalise(horizontal: Axis, vertical: Axis) -> tuple[Axis, Axis]:
    """Return axes of one scale in both directions."""
    width, height = _WIDTH - _LEFT - _RIGHT, _HEIGHT - _TOP - _BOTTOM
    scale = max((horizontal.upper - horizontal.lower) / width, (vertical.upper - vertical.lower) / height)

    def widen(axis: Axis, pixels: float) -> Axis:
        middle = (axis.lower + axis.upper) / 2
        return Axis(middle - scale * pixels / 2, middle + scale * pixels / 2)

    return widen(horizontal, width), widen(vertical, height)


def _screen(axis: Axis, values: Array, vertical: bool) -> Array:
    share = np.clip(axis.place(np.asarray(values, dtype=np.float64)), -0.5, 1.5)
    if vertical:
        return np.asarray(_HEIGHT - _BOTTOM - share * (_HEIGHT - _TOP - _BOTTOM))
    return np.asarray(_LEFT + share * (_WIDTH - _LEFT - _RIGHT))


def _grid(horizontal: Axis, vertical: Axis, heights: bool = True) -> str:
    parts = []
    top, bottom = _TOP, _HEIGHT - _BOTTOM
    for value, label in horizontal.ticks():
        x = float(_screen(horizontal, np.array(value), False))
        parts.append(
            f'<path class="grid" d="M{x:.1f} {top}V{bottom}"/>'
            f'<text class="tick" x="{x:.1f}" y="{bottom + 14}">{label}</text>'
        )
    for value, label in vertical.ticks() if heights else ():
        y = float(_screen(vertical, np.array(value), True))
        parts.append(
            f'<path class="grid" d="M{_LEFT} {y:.1f}H{_WIDTH - _RIGHT}"/>'
            f'<text class="tick side" x="{_LEFT - 5}" y="{y + 3.5:.1f}">{label}</text>'
        )
    return "".join(parts)


def _path(horizontal: Axis, vertical: Axis, line: Line) -> str:
    keep = np.isfinite(line.x) & np.isfinite(line.y)
    x, y = _screen(horizontal, line.x[keep], False), _screen(vertical, line.y[keep], True)
    if x.size == 0:
        return ""
    if line.step:
        x, y = np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]
    return f'<path class="{_style(line)}" d="{_commands(x, y)}"/>'


def _band(horizontal: Axis, vertical: Axis, x: Array, lower: Array, upper: Array, colour: int) -> str:
    keep = np.isfinite(x) & np.isfinite(lower) & np.isfinite(upper)
    if not keep.any():
        return ""
    across = _screen(horizontal, x[keep], False)
    low, high = _screen(vertical, lower[keep], True), _screen(vertical, upper[keep], True)
    outline = _commands(np.concatenate([across, across[::-1]]), np.concatenate([low, high[::-1]]))
    return f'<path class="band c{colour % COLOURS}" d="{outline}Z"/>'


def _commands(x: Array, y: Array) -> str:
    points = [f"{across:.1f} {down:.1f}" for across, down in zip(x.tolist(), y.tolist(), strict=True)]
    kept = [point for place, point in enumerate(points) if place == 0 or point != points[place - 1]]
    return "M" + "L".join(kept if len(kept) > 1 else kept * 2)


def _style(line: Line) -> str:
    colour = "limit" if line.colour == LIMIT else f"c{line.colour % COLOURS}"
    return f"line {colour}{' dashed' if line.dashed else ''}{' wide' if line.wide else ''}"
