"""Any value, text or override in a case file is read or refused by name."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ocp_traj.case import case_template, load_case_text
from ocp_traj.exceptions import CaseError

GOOD = """schema = 1
name = "small"
waypoints.joints = [[0.0, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.0]]
limits.velocity = 1.0
"""

VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=20)
    | st.sampled_from(["deg", "m", "ur5", "cubic", "zero", "free", "3-5-3", 1, [0.0] * 6]),
    lambda inner: st.lists(inner, max_size=7) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=20,
)
TEMPLATE_KEYS = [
    "schema", "name", "title", "source", "robot", "robot.model", "robot.dh", "robot.tool", "robot.payload",
    "robot.gravity", "robot.friction", "robot.motor", "robot.urdf", "robot.lock", "waypoints", "waypoints.unit",
    "waypoints.joints", "waypoints.tolerance", "limits", "limits.unit", "limits.velocity",
    "limits.acceleration", "limits.jerk", "limits.position", "limits.torque", "limits.torque_rate", "limits.gaps",
    "limits.cartesian_speed", "spline", "spline.family", "spline.virtual_knots", "boundary", "boundary.velocity",
    "boundary.acceleration", "boundary.jerk", "objective", "objective.time", "objective.energy", "objective.bounds",
    "search", "search.duration", "search.protocol",
]  # fmt: skip


@settings(max_examples=300)
@given(key=st.sampled_from(TEMPLATE_KEYS), value=VALUES)
def test_any_value_at_any_key_is_read_or_refused_by_name(key: str, value: object, tmp_path_factory) -> None:
    from ocp_traj.case.reading import task_from_tables
    from ocp_traj.case.toml_files import parse_toml

    tables = parse_toml(case_template(), "fuzz")
    *parents, last = key.split(".")
    table = tables
    for name in parents:
        table = table.setdefault(name, {})
    table[last] = value
    try:
        task_from_tables(tables, "fuzz", tmp_path_factory.getbasetemp())
    except CaseError as error:
        assert error.file == "fuzz"


@settings(max_examples=300)
@given(st.text(max_size=200) | st.binary(max_size=200).map(lambda data: data.decode("latin-1")))
def test_any_text_is_read_or_refused(text: str) -> None:
    with pytest.raises(CaseError):
        load_case_text(text)


@settings(max_examples=300)
@given(st.text(max_size=60) | st.from_regex(r"[a-z.]{0,12}=[\[\]{}0-9a-z\"',= ]{0,20}", fullmatch=True))
def test_any_override_is_applied_or_refused(override: str) -> None:
    try:
        load_case_text(GOOD, [override])
    except CaseError as error:
        assert error.file == "<text>"
