"""Results, exact curves and tables of samples from anybody: a verdict, a picture or one sentence, nothing else."""

from __future__ import annotations

import copy
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ocp_traj.audit import audit
from ocp_traj.cli.main import run
from ocp_traj.exceptions import InputError, OcpTrajError
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.trajectory_files import from_json, read_csv, read_json

CURVE = {
    "schema": 1,
    "case": "c",
    "family": "cubic",
    "waypoint_times": [0.0, 2.0],
    "breakpoints": [0.0, 1.0, 2.0],
    "coefficients": [[[0.0, 0.0, 1.5, -0.5]], [[1.0, 1.5, 0.0, -0.5]]],
}
RESULT = {"schema": 1, "case": "c", "solver": "ipopt", "feasible": True, "duration": 2.0, "trajectory": CURVE}
NUMBERS = st.sampled_from(
    [
        0.0,
        -0.0,
        1e-320,
        5e-324,
        1e-308,
        1e-16,
        1.0,
        1e16,
        1e150,
        1e300,
        1.7e308,
        -1.7e308,
        2**63,
        2**64,
        10**400,
    ]
)
ODD = (
    NUMBERS
    | st.none()
    | st.booleans()
    | st.text(max_size=4)
    | st.sampled_from([float("nan"), float("inf"), [], {}, [[]], [[[]]], "../../etc/passwd", "<script>"])
)
QUIET = settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the paths of everything inside a JSON value."""
    keys = value.keys() if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    return [path] * bool(path) + [place for key in keys for place in places(value[key], (*path, key))]


def changed(value: Any, path: tuple[Any, ...], new: Any) -> Any:
    value = copy.deepcopy(value)
    inner = value
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = new
    return value


def judge(motion: Trajectory) -> None:
    """The verdict on any motion that could be read: a boolean, ratios that are numbers or infinite, plain JSON."""
    limits = Limits(position=10.0, velocity=2.0, acceleration=4.0, jerk=50.0)
    with np.errstate(all="ignore"):
        waypoints = np.clip(motion(motion.waypoint_times), -1.0, 1.0)
        verdict = audit(TrajectoryTask(np.nan_to_num(waypoints), limits), motion)
    assert all(not np.isnan(peak.ratio) for peak in verdict.limits.values())
    assert verdict.feasible is (not verdict.findings)
    json.dumps(verdict.to_json(), allow_nan=False)


@QUIET
@given(st.lists(st.tuples(st.sampled_from(places(RESULT)), ODD), min_size=1, max_size=3))
def test_a_changed_result_is_judged_or_refused(tmp_path: Path, changes: list[tuple[Any, Any]]) -> None:
    data: Any = RESULT
    for path, new in changes:
        try:
            data = changed(data, path, new)
        except (KeyError, IndexError, TypeError):  # an earlier change took this place away
            continue
    (tmp_path / "result.json").write_text(json.dumps(data))
    try:
        motion = read_json(tmp_path / "result.json")
    except InputError as error:
        assert "result.json" in str(error)
    else:
        judge(motion)


@QUIET
@given(
    st.lists(NUMBERS, min_size=2, max_size=4),
    st.lists(NUMBERS, min_size=4, max_size=4),
)
def test_enormous_and_tiny_numbers_are_judged_or_refused(times: list[float], numbers: list[float]) -> None:
    breakpoints = sorted(float(min(time, 1.7e308)) for time in times)
    pieces = [[[float(min(number, 1.7e308)) for number in numbers]]] * (len(times) - 1)
    data = {
        "schema": 1,
        "breakpoints": breakpoints,
        "waypoint_times": [breakpoints[0], breakpoints[-1]],
        "coefficients": pieces,
    }
    try:
        motion = from_json(data, "FILE")
    except InputError as error:
        assert str(error).startswith("FILE: ")
    else:
        judge(motion)


@QUIET
@given(st.binary(max_size=200) | st.text(alphabet='{}[]",:0123eE.-+truefalsn', max_size=80).map(str.encode))
def test_any_bytes_are_refused_by_name(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "odd.json").write_bytes(content)
    with pytest.raises(InputError, match=r"odd\.json"):
        read_json(tmp_path / "odd.json")


CELLS = st.sampled_from(
    [
        "0",
        "1",
        "-1",
        "1e308",
        "-1e308",
        "1e-320",
        "1e400",
        "nan",
        "inf",
        "",
        "x",
        "1_0",
        "0x1",
        " 2 ",
        "١",
        "1;2",
    ]
)


@QUIET
@given(
    st.lists(st.lists(CELLS, min_size=4, max_size=4), max_size=4),
    st.sampled_from(["t,q1,v1,a1", "t,q1,v1,a²"]),
)
def test_any_table_is_a_motion_or_refused(tmp_path: Path, rows: list[list[str]], header: str) -> None:
    (tmp_path / "odd.csv").write_text("\n".join([header, *(",".join(row) for row in rows)]), encoding="utf-8")
    with np.errstate(all="ignore"):
        try:
            motion = read_csv(tmp_path / "odd.csv")
        except InputError:
            return
    judge(motion)


@pytest.mark.parametrize("command", ["audit", "plot", "export", "reference"])
@pytest.mark.parametrize(
    "content",
    [
        "[]",
        "3",
        '"text"',
        "null",
        "{}",
        '{"trajectory": null}',
        '{"trajectory": []}',
        '{"trajectory": {"schema": 1}}',
        '{"schema": 1, "breakpoints": [0, 1e999], "waypoint_times": [0, 1], "coefficients": [[[0]]]}',
        "[" * 50_000,
        "9" * 5_000,
    ],
)
def test_every_command_refuses_what_is_no_motion(
    tmp_path: Path, command: str, content: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "odd.json"
    path.write_text(content)
    arguments = {
        "audit": ["audit", "fang-2020-task-1", "--result", str(path)],
        "plot": ["plot", str(path)],
        "export": ["export", str(path), "--format", "csv"],
        "reference": ["reference", "fang-2020-task-1", "--result", str(path)],
    }[command]
    assert run(arguments) == 2
    said = capsys.readouterr().err
    assert "odd.json" in said
    assert len(said.splitlines()) == 1
    assert [entry.name for entry in tmp_path.iterdir()] == ["odd.json"]


@pytest.mark.parametrize(
    "case", ["../../../etc/passwd", "/etc/passwd", "evil.toml", "__import__('os')", "<b>"]
)
def test_the_case_a_motion_names_is_never_read_from_a_path(
    tmp_path: Path, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "evil.toml").write_text("schema = 1\nthis would be an error")
    (tmp_path / "m.json").write_text(
        json.dumps({**RESULT, "case": case, "trajectory": {**CURVE, "case": case}})
    )
    assert run(["export", "m.json", "--format", "csv", "--output", "m.csv"]) == 0
    assert read_csv(tmp_path / "m.csv").duration == 2.0


@pytest.mark.parametrize("reader", [read_json, read_csv])
def test_devices_pipes_and_null_characters_are_no_files(tmp_path: Path, reader: Any) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path, reason in ((Path("/dev/zero"), "regular"), (pipe, "regular"), (tmp_path, "cannot be read")):
        with pytest.raises(InputError, match=reason):
            reader(path)
    with pytest.raises(InputError, match="null character"):
        reader("a\0b")


def test_an_export_of_days_at_a_megahertz_is_refused_before_it_fills_the_disk(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    days = {**CURVE, "waypoint_times": [0, 1e6], "breakpoints": [0, 5e5, 1e6]}
    (tmp_path / "long.json").write_text(json.dumps(days))
    for kind in ("csv", "ros2", "urscript"):
        assert run(["export", str(tmp_path / "long.json"), "--format", kind, "--rate", "1e6"]) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    assert len(list(tmp_path.iterdir())) == 1


def test_errors_of_the_library_are_one_family() -> None:
    assert issubclass(InputError, OcpTrajError)
