"""The columns of a CSV file are held against the exact curve beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from helpers.audit_motions import clamped_cubic
from ocp_traj.exceptions import InputError
from ocp_traj.trajectory import Trajectory
from ocp_traj.trajectory_files import read_csv, write_csv


def motion() -> Trajectory:
    return clamped_cubic(np.array([[0.0, 1.0], [1.0, -1.0], [0.5, 0.0]]), np.array([0.5, 0.7]))


def changed(path: Path, column: str, row: int, value: str) -> None:
    """Replace one entry of a CSV file."""
    lines = path.read_text().splitlines()
    index = lines[0].split(",").index(column)
    entries = lines[row].split(",")
    entries[index] = value
    lines[row] = ",".join(entries)
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("rate", [1000.0, 7.0])
def test_a_file_as_written_is_read(tmp_path: Path, rate: float) -> None:
    """Samples on breakpoints, where accelerations have two values, included."""
    path = tmp_path / "a.csv"
    write_csv(path, motion(), rate=rate)
    assert read_csv(path).n == 2


@pytest.mark.parametrize("column", ["v1", "v2", "a1", "a2", "j2"])
@pytest.mark.parametrize("row", [1, 300, 1201])
def test_an_entry_that_the_curve_does_not_have_is_named(tmp_path: Path, column: str, row: int) -> None:
    path = tmp_path / "a.csv"
    write_csv(path, motion())
    changed(path, column, row, "99")
    with pytest.raises(InputError, match=rf"a\.csv: row {row}: {column} is 99, but a\.spline\.json has "):
        read_csv(path)


def test_rounded_columns_are_no_disagreement(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    write_csv(path, motion())
    lines = path.read_text().splitlines()
    rounded = [",".join(f"{float(entry):.9g}" for entry in line.split(",")) for line in lines[1:]]
    path.write_text("\n".join([lines[0], *rounded]) + "\n")
    assert read_csv(path).n == 2


def test_without_jerks_the_rest_is_compared(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    write_csv(path, motion())
    lines = [",".join(line.split(",")[:7]) for line in path.read_text().splitlines()]
    path.write_text("\n".join(lines) + "\n")
    assert read_csv(path).n == 2
    changed(path, "a2", 5, "99")
    with pytest.raises(InputError, match="row 5: a2 is 99"):
        read_csv(path)


def test_the_jerk_of_either_piece_will_do_where_they_meet(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    write_csv(path, motion())
    curve = motion()
    before = curve(0.5 - 1e-6, 3)[0]
    assert before != curve(0.5, 3)[0]
    changed(path, "j1", 501, repr(float(before)))
    assert read_csv(path).n == 2
