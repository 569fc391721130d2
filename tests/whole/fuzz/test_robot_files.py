"""Robot descriptions from anybody: a robot or one sentence; no file but the one named is read, no memory is eaten."""

from __future__ import annotations

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ocp_traj.exceptions import RobotError
from ocp_traj.robot import robot_from_urdf
from ocp_traj.robot.description import document

LINKS = '<link name="l0"/><link name="l1"/>'
INERTIAL = """<inertial><origin xyz="{origin} 0 0"/><mass value="{mass}"/>
<inertia ixx="{moment}" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"""
NUMBERS = st.sampled_from(
    ["0", "-0", "1", "-1", "1e-320", "1e300", "1e400", "-1e308", "nan", "inf", "", "x", "1,5", "0x10"]
)


def joint(number: int, parent: int, child: int, inside: str = "") -> str:
    return (
        f'<joint name="j{number}" type="revolute"><parent link="l{parent}"/><child link="l{child}"/>'
        f'<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>{inside}</joint>'
    )


def write(folder: Path, inside: str, before: str = "") -> Path:
    path = folder / "arm.urdf"
    path.write_text(f'{before}<robot name="r">{inside}</robot>', encoding="utf-8")
    return path


def body(**numbers: object) -> str:
    inertial = INERTIAL.format(**{"origin": 0, "mass": 1, "moment": 1, **numbers})
    return f'<link name="l0"/><link name="l1">{inertial}</link>' + joint(0, 0, 1)


def chain(count: int) -> str:
    links = "".join(f'<link name="l{index}"/>' for index in range(count + 1))
    return links + "".join(joint(index, index, index + 1) for index in range(count))


@pytest.mark.parametrize(
    "inside",
    [
        "<a>" * 100_000 + "</a>" * 100_000,
        LINKS + joint(0, 0, 1) + joint(1, 1, 0),
        LINKS + joint(0, 0, 1) + joint(1, 1, 1),
        LINKS + joint(0, 0, 1) + joint(0, 0, 1),
        LINKS + joint(0, 0, 7),
        LINKS + joint(0, 0, 1, '<origin xyz="nan 0 0"/>'),
        LINKS,
        "",
    ],
    ids=["nested", "circle", "itself", "twice", "nowhere", "nan", "no joint", "empty"],
)
def test_what_is_no_arm_is_refused_by_name(tmp_path: Path, inside: str) -> None:
    with pytest.raises(RobotError, match=r"arm\.urdf"):
        robot_from_urdf(write(tmp_path, inside))


@pytest.mark.parametrize(
    ("numbers", "reason"),
    [
        ({"mass": -5}, "j0: its link has a mass of -5 kg, expected 0 or more"),
        ({"mass": "1e308", "origin": "1e10"}, "j0: .* not finite"),
    ],
)
def test_links_that_cannot_be_are_refused(tmp_path: Path, numbers: dict[str, object], reason: str) -> None:
    assert robot_from_urdf(write(tmp_path, body())).has_inertia
    with pytest.raises(RobotError, match=rf"arm\.urdf: joint {reason}"):
        robot_from_urdf(write(tmp_path, body(**numbers)))


@pytest.mark.parametrize("value", ["nan", "inf", "1e400", "x", "", "1,5", "${mass}"])
@pytest.mark.parametrize(("tag", "name"), [("mass", "value"), ("inertia", "ixx")])
def test_a_mass_that_is_no_number_is_refused_instead_of_left_out(
    tmp_path: Path, value: str, tag: str, name: str
) -> None:
    numbers = {"mass" if tag == "mass" else "moment": value}
    with pytest.raises(RobotError, match=rf"arm\.urdf: link 'l1': <{tag} {name}=.*> given, expected a finite number"):
        robot_from_urdf(write(tmp_path, body(**numbers)))


def test_masses_in_comments_do_not_count(tmp_path: Path) -> None:
    path = write(tmp_path, body() + '<!-- <mass value="?"/>\n<inertia ixx="?"/> -->')
    assert robot_from_urdf(path).has_inertia


def test_too_many_joints_are_refused(tmp_path: Path) -> None:
    assert robot_from_urdf(write(tmp_path, chain(30))).n == 30
    with pytest.raises(RobotError, match="has 201 joints, expected at most 200"):
        robot_from_urdf(write(tmp_path, chain(201)))


def test_a_description_that_is_too_large_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(document, "MAX_BYTES", 100)
    with pytest.raises(RobotError, match="is larger than 100 bytes"):
        robot_from_urdf(write(tmp_path, chain(3)))


@pytest.mark.parametrize("path", ["/dev/zero", "/etc", "/no/such.urdf"])
def test_what_is_no_file_does_not_exist(path: str) -> None:
    with pytest.raises(RobotError, match="does not exist"):
        robot_from_urdf(path)


def test_entities_are_neither_expanded_nor_fetched(tmp_path: Path) -> None:
    secret = tmp_path / "secret.txt"
    secret.write_text("do not read me")
    bomb = "".join(f'<!ENTITY e{n + 1} "{f"&e{n};" * 10}">' for n in range(9))
    head = f'<!DOCTYPE r [<!ENTITY s SYSTEM "file://{secret}"><!ENTITY e0 "ha">{bomb}]>'
    path = tmp_path / "arm.urdf"
    path.write_text(f'{head}<robot name="&s;&e9;">{LINKS}{joint(0, 0, 1)}</robot>')
    with pytest.raises(RobotError, match=r"arm\.urdf defines XML entities, expected plain XML"):
        robot_from_urdf(path)


def test_the_largest_description_read_stays_within_two_gigabytes(tmp_path: Path) -> None:
    path = write(tmp_path, chain(200))
    program = f"""
        import resource
        resource.setrlimit(resource.RLIMIT_AS, (4 * 2**30, 4 * 2**30))
        from ocp_traj.robot import robot_from_urdf
        assert robot_from_urdf({str(path)!r}).n == 200
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 < 2 * 2**30
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(NUMBERS, NUMBERS, NUMBERS, NUMBERS, NUMBERS)
def test_any_number_at_any_place_is_a_robot_or_refused(
    tmp_path: Path, mass: str, moment: str, origin: str, place: str, limit: str
) -> None:
    inside = body(mass=mass, moment=moment, origin=origin)
    inside = inside.replace('lower="-1"', f'lower="{limit}"').replace(
        "</joint>", f'<origin xyz="{place} 0 0"/></joint>'
    )
    path = write(tmp_path, inside)
    try:
        robot = robot_from_urdf(path)
    except RobotError as error:
        assert "arm.urdf" in str(error)
    else:
        assert robot.n == 1
