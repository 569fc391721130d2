"""A report before it is HTML or Markdown: sections of paragraphs, tables and pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ocp_traj.pictures.picture import Picture


@dataclass(frozen=True)
class Cell:
    """A table's cell: what is shown, what it is sorted by, and a tone (``good``, ``bad`` or none)."""

    text: str
    sort: float | str
    tone: str = ""


@dataclass(frozen=True)
class Table:
    """A table with a caption and a note below; every row has as many cells as there are columns.

    The first `words` columns hold words, the others numbers; `wide` columns hold sentences.
    """

    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    words: int = 1
    wide: tuple[int, ...] = ()

    def kind(self, column: int) -> str:
        """Return ``wide``, ``words`` or nothing: how a column is set."""
        return "wide" if column in self.wide else ("words" if column < self.words else "")


@dataclass(frozen=True)
class Fold:
    """Pictures and tables behind a line that can be opened."""

    title: str
    pictures: tuple[Picture, ...] = ()
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True)
class ReportSection:
    """A heading with what belongs to it, in this order."""

    anchor: str
    title: str
    paragraphs: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    folds: tuple[Fold, ...] = ()


@dataclass(frozen=True)
class Document:
    """A whole report; `story` comes first."""

    title: str
    subtitle: str
    story: tuple[str, ...]
    sections: tuple[ReportSection, ...]


def text(value: str, tone: str = "") -> Cell:
    """Return a cell of words."""
    return Cell(value, value, tone)


def number(value: float | None, digits: int = 4, tone: str = "", suffix: str = "") -> Cell:
    """Return a cell of a number; what is missing or infinite is a dash and sorts last."""
    if value is None or not math.isfinite(value):
        return Cell("–", math.inf, tone)
    return Cell(format_number(value, digits) + suffix, float(value), tone)


def count(value: float | None) -> Cell:
    """Return a cell of a whole number (a median of two may end in .5)."""
    if value is None or not math.isfinite(value):
        return Cell("–", math.inf)
    return Cell(f"{value:.10g}", float(value))


def format_number(value: float, digits: int = 4) -> str:
    """Return a number with so many significant digits, plainly written where that is readable."""
    if value == 0:
        return "0"
    power = math.floor(math.log10(abs(value)))
    if -4 <= power < 7:
        return f"{value:.{max(digits - 1 - power, 0)}f}"
    return f"{value:.{digits - 1}e}"


def to_markdown(document: Document) -> str:
    """Return the report as Markdown: the same words and numbers, pictures by their captions, and no HTML."""
    blocks = [f"# {_plain(document.title)}", _plain(document.subtitle)]
    if document.story:
        blocks.append("\n".join(f"- {_plain(line)}" for line in document.story))
    for section in document.sections:
        blocks.append(f"## {_plain(section.title)}")
        blocks += [_plain(paragraph) for paragraph in section.paragraphs]
        blocks += [_markdown_table(table) for table in section.tables]
        blocks += [_caption(picture) for picture in section.pictures]
        for fold in section.folds:
            blocks.append(f"### {_plain(fold.title)}")
            blocks += [_markdown_table(table) for table in fold.tables]
            blocks += [_caption(picture) for picture in fold.pictures]
    return "\n\n".join(blocks) + "\n"


def _markdown_table(table: Table) -> str:
    lines = [f"**{_plain(table.caption)}**", ""] if table.caption else []
    lines += [
        "| " + " | ".join(_escape(column) for column in table.columns) + " |",
        "|" + " --- |" * len(table.columns),
    ]
    lines += ["| " + " | ".join(_escape(cell.text) for cell in row) + " |" for row in table.rows]
    if table.note:
        lines += ["", _plain(table.note)]
    return "\n".join(lines)


def _caption(picture: Picture) -> str:
    return f"*{_plain(picture.title)}: {_plain(picture.caption)}*"


def _plain(value: str) -> str:
    """Return words in which nothing is read as HTML."""
    return value.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def _escape(value: str) -> str:
    return _plain(value).replace("\\", "\\\\").replace("|", "\\|").replace("\n", " ")
