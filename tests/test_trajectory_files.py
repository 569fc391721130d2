"""Trajectory files: exact round trips, what others may write, and refusals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ocp_traj import trajectory_files
from ocp_traj.exceptions import InputError
from ocp_traj.trajectory import Trajectory
from ocp_traj.trajectory_files import from_json, read_csv, read_json, to_json, write_csv, write_json


def some_trajectory(seed: int = 0) -> Trajectory:
    rng = np.random.default_rng(seed)
    breakpoints = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 0.3, 4))])
    return Trajectory(breakpoints, rng.normal(size=(4, 2, 4)), breakpoints[[0, 2, 4]], "cubic", "some-case")


def same(one: Trajectory, other: Trajectory) -> bool:
    return (
        np.array_equal(one.breakpoints, other.breakpoints)
        and np.array_equal(one.coefficients, other.coefficients)
        and np.array_equal(one.waypoint_times, other.waypoint_times)
        and (one.family, one.case) == (other.family, other.case)
    )


def test_json_round_trips_exactly(tmp_path: Path) -> None:
    trajectory = some_trajectory()
    assert same(from_json(json.loads(json.dumps(to_json(trajectory)))), trajectory)
    write_json(tmp_path / "a.spline.json", trajectory)
    assert same(read_json(tmp_path / "a.spline.json"), trajectory)


def test_json_has_the_keys_of_the_contract() -> None:
    data = to_json(some_trajectory())
    assert list(data) == ["schema", "case", "family", "waypoint_times", "breakpoints", "coefficients"]
    assert data["schema"] == 1
    assert np.shape(data["coefficients"]) == (4, 2, 4)


def test_the_curve_inside_a_result_is_read(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    path.write_text(json.dumps({"schema": 1, "feasible": True, "trajectory": to_json(some_trajectory())}))
    assert same(read_json(path), some_trajectory())
    path.write_text(json.dumps({"schema": 1, "feasible": False, "trajectory": None}))
    with pytest.raises(InputError, match="trajectory: is null"):
        read_json(path)


def test_csv_has_header_rate_and_exact_ends(tmp_path: Path) -> None:
    trajectory = some_trajectory()
    write_csv(tmp_path / "a.csv", trajectory, rate=250.0)
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert lines[0] == "t,q1,q2,v1,v2,a1,a2,j1,j2"
    table = np.array([line.split(",") for line in lines[1:]], dtype=float)
    assert table[0, 0] == 0.0
    assert table[-1, 0] == trajectory.breakpoints[-1]
    assert np.diff(table[:-1, 0]) == pytest.approx(1 / 250)
    assert 0 < table[-1, 0] - table[-2, 0] <= 1 / 250 + 1e-9
    for order in range(4):
        assert np.array_equal(table[:, 1 + 2 * order : 3 + 2 * order], trajectory(table[:, 0], order))


def test_a_duration_of_whole_samples_has_no_extra_row(tmp_path: Path) -> None:
    trajectory = Trajectory([0.0, 0.3], np.zeros((1, 1, 4)), [0.0, 0.3])
    write_csv(tmp_path / "a.csv", trajectory)
    assert len((tmp_path / "a.csv").read_text().splitlines()) == 1 + 301


def test_torques_are_written_on_request(tmp_path: Path) -> None:
    def torques(q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        return 2 * a + q

    write_csv(tmp_path / "a.csv", some_trajectory(), torques=torques)
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert lines[0].endswith(",j1,j2,tau1,tau2")
    row = [float(entry) for entry in lines[5].split(",")]
    assert row[9:] == pytest.approx([2 * row[5] + row[1], 2 * row[6] + row[2]])


def test_the_exact_curve_beside_a_csv_is_used(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", some_trajectory())
    assert (tmp_path / "a.spline.json").exists()
    assert same(read_csv(tmp_path / "a.csv"), some_trajectory())


def test_an_exact_curve_of_another_motion_is_refused(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", some_trajectory())
    write_json(tmp_path / "a.spline.json", some_trajectory(1))
    with pytest.raises(InputError, match=r"a\.spline\.json: is another motion than .*a\.csv"):
        read_csv(tmp_path / "a.csv")
    one = some_trajectory()
    write_json(
        tmp_path / "a.spline.json", Trajectory(one.breakpoints, one.coefficients[:, :1], one.waypoint_times)
    )
    with pytest.raises(InputError, match=r"has 1 joints, but .* has 2"):
        read_csv(tmp_path / "a.csv")


def test_without_it_the_quintic_through_the_samples_is(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    smooth = Trajectory([0.0, 0.9], rng.normal(size=(1, 2, 6)), [0.0, 0.9], "quintic")
    write_csv(tmp_path / "a.csv", smooth, rate=10.0)
    (tmp_path / "a.spline.json").unlink()
    read = read_csv(tmp_path / "a.csv")
    times = np.linspace(0, 0.9, 333)
    for order in range(4):
        assert read(times, order) == pytest.approx(smooth(times, order), rel=1e-7, abs=1e-7)
    assert read.waypoint_times.tolist() == [0.0, 0.9]


def test_a_foreign_csv_needs_only_positions_velocities_and_accelerations(tmp_path: Path) -> None:
    path = tmp_path / "foreign.csv"
    path.write_text("\ufefft, q1, v1, a1, note\r\n0, 0, 0, 6, 1\r\n1, 1, 0, -6, 2\r\n\r\n", encoding="utf-8")
    assert read_csv(path)(0.5) == pytest.approx([0.5])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "header: '' given, expected t,q1"),
        ("a,b\n1,2\n", "header: 'a,b' given"),
        ("t,q1,v1\n0,0,0\n1,1,0\n", "column a1 is missing"),
        ("t,q1,v1,a1\n0,0,0,0\n", "1 rows given, expected at least 2"),
        ("t,q1,v1,a1\n0,0,0,0\n1,1,0\n", "row 2 has 3 entries, expected 4"),
        ("t,q1,v1,a1\n0,0,0,0\n1,one,0,0\n", "something else than numbers"),
        ("t,q1,v1,a1\n0,0,0,0\n1,nan,0,0\n", "row 2: q1 is nan, expected a finite number"),
        ("t,q1,v1,a1\n0,0,0,0\n0,1,0,0\n", "the times do not increase strictly"),
    ],
)
def test_a_csv_that_is_no_motion_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as raised:
        read_csv(path)
    assert "bad.csv" in str(raised.value)


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.csv: cannot be read: No such file"):
        read_csv(tmp_path / "none.csv")
    with pytest.raises(InputError, match=r"cannot be read: Is a directory"):
        read_json(tmp_path)
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00t,q1")
    with pytest.raises(InputError, match=r"bytes\.csv: is no text"):
        read_csv(tmp_path / "bytes.csv")
    (tmp_path / "text.json").write_text("{not json")
    with pytest.raises(InputError, match=r"text\.json: is no JSON"):
        read_json(tmp_path / "text.json")
    (tmp_path / "deep.json").write_text("[" * 100_000)
    with pytest.raises(InputError, match=r"deep\.json: is no JSON"):
        read_json(tmp_path / "deep.json")


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trajectory_files, "_MAX_BYTES", 10)
    write_csv(tmp_path / "a.csv", some_trajectory())
    with pytest.raises(InputError, match=r"a\.csv: cannot be read: it is larger than 10 bytes"):
        read_csv(tmp_path / "a.csv")


def test_files_that_cannot_be_written_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.csv: cannot be written: No such file"):
        write_csv(tmp_path / "missing" / "a.csv", some_trajectory())
    (tmp_path / "a.csv").mkdir()
    with pytest.raises(InputError, match=r"a\.csv: cannot be written"):
        write_csv(tmp_path / "a.csv", some_trajectory())
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def test_a_rate_must_be_sensible(tmp_path: Path) -> None:
    for rate in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InputError, match="expected a positive number of samples"):
            write_csv(tmp_path / "a.csv", some_trajectory(), rate=rate)
    with pytest.raises(InputError, match="expected a lower rate"):
        write_csv(tmp_path / "a.csv", some_trajectory(), rate=1e9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema": 2}, "schema: 2 given, expected 1"),
        ({"coefficients": None}, "coefficients: expected finite numbers in 3 levels"),
        ({"coefficients": [[[0.0, 1.0]], [[1.0]]]}, "coefficients: rows differ in length"),
        ({"coefficients": [[["0.0", "1.0"]]]}, "coefficients: expected finite numbers in 3 levels"),
        ({"coefficients": [[[True, False]]]}, "coefficients: expected finite numbers in 3 levels"),
        ({"coefficients": [[[10**400, 1]]]}, "coefficients: expected finite numbers in 3 levels"),
        ({"coefficients": [[[1.0] * 40]]}, "coefficients: degree 39, expected at most 30"),
        ({"breakpoints": [0.0, float("nan")]}, "breakpoints: holds a number that is not finite"),
        ({"breakpoints": []}, "breakpoints: expected finite numbers in 1 levels"),
        ({"breakpoints": [0.0, 0.0]}, "breakpoints must increase strictly"),
        ({"breakpoints": [0.0, 1.0, 2.0]}, "got shapes"),
        ({"waypoint_times": [0.0, 0.5]}, "expected its span"),
        ({"family": 3}, "family: 3 given, expected a text"),
    ],
)
def test_json_that_is_no_motion_is_refused(change: dict[str, Any], message: str) -> None:
    data = {
        "schema": 1,
        "waypoint_times": [0.0, 1.0],
        "breakpoints": [0.0, 1.0],
        "coefficients": [[[0.0, 1.0]]],
    }
    assert from_json(data).n == 1
    with pytest.raises(InputError, match=message) as raised:
        from_json({**data, **change}, "FILE")
    assert str(raised.value).startswith("FILE: ")


def test_a_missing_key_is_named() -> None:
    with pytest.raises(InputError, match="FILE: breakpoints: is missing"):
        from_json({"schema": 1}, "FILE")
    with pytest.raises(InputError, match="FILE: holds a list, expected an object"):
        from_json([], "FILE")


_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=12,
)


@given(
    st.fixed_dictionaries(
        {"schema": st.just(1)},
        optional=dict.fromkeys(("waypoint_times", "breakpoints", "coefficients", "family", "case"), _values),
    )
)
def test_whatever_is_in_the_file_only_input_errors_come_out(data: dict[str, Any]) -> None:
    try:
        from_json(data)
    except InputError as error:
        assert str(error).startswith("trajectory: ")


@given(st.text(alphabet="tqva1,.e-0 \nx", max_size=60))
def test_whatever_text_a_csv_holds_only_input_errors_come_out(text: str) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fuzz.csv"
        path.write_text(text)
        try:
            read_csv(path)
        except InputError as error:
            assert "fuzz.csv" in str(error)
