"""What a picture shows, apart from how it is drawn: `svg` draws it into pages, `drawing` into files."""

from __future__ import annotations

from dataclasses import dataclass, field

from ocp_traj.arrays import Array

LIMIT = -1
"""Colour number of limits and references."""


@dataclass(frozen=True)
class Line:
    """A curve; equal colours in one picture mean the same thing."""

    x: Array
    y: Array
    label: str = ""
    colour: int = 0
    dashed: bool = False
    step: bool = False
    wide: bool = False


@dataclass(frozen=True)
class Band:
    """The area between two curves."""

    x: Array
    lower: Array
    upper: Array
    colour: int = 0


@dataclass(frozen=True)
class Panel:
    """One pair of axes; with `row_names`, heights 0, 1, 2 ... are rows with these names, from below."""

    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    bands: tuple[Band, ...] = ()
    log_x: bool = False
    log_y: bool = False
    equal: bool = False
    y_range: tuple[float, float] | None = None
    row_names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Picture:
    """Panels side by side under one title, with one legend.

    Parameters
    ----------
    name
        Short name for files and commands.
    title, caption
        For people.
    panels
        In reading order.
    """

    name: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int = field(default=2)

    @property
    def legend(self) -> dict[str, Line]:
        """First line of every label."""
        entries: dict[str, Line] = {}
        for panel in self.panels:
            for line in panel.lines:
                if line.label:
                    entries.setdefault(line.label, line)
        return entries
