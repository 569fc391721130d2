"""Joint limits from a MoveIt configuration."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

# MoveIt's word for a quantity, and ours.
_FILE_NAMES = {
    "position": "position",
    "velocity": "velocity",
    "acceleration": "acceleration",
    "jerk": "jerk",
    "effort": "torque",
}


def limits_from_moveit(path: str | Path, robot: Robot) -> dict[str, Array]:
    """Return what a MoveIt ``joint_limits.yaml`` limits: for each quantity (2, n), lower and upper, in SI.

    The file's ``has_..._limits`` switches are obeyed, its default scaling factors are applied to velocity and
    acceleration, ``max_effort`` gives the torque, and values tagged ``!degrees`` or ``!radians`` are understood.
    A missing ``min_velocity`` (and so on) is minus the maximum. Joints of the file that the robot has not are left
    aside; joints whose switch is not set keep the robot's own position, velocity and torque limits.

    Parameters
    ----------
    path : path
    robot : Robot
        Gives the joints' names and order, and its limits where the file has none.

    Returns
    -------
    dict
        Keys among "position", "velocity", "acceleration", "jerk", "torque", only those the file says something
        about; rad and s, m for prismatic joints, N m; infinite where there is no limit.

    Raises
    ------
    InputError
        The file is missing, no YAML, has no ``joint_limits``, names none of the robot's joints, or a value is no
        number or of the wrong sign; names the joint and the key.
    """
    content = _read(Path(path))
    joints = content.get("joint_limits")
    if not isinstance(joints, dict):
        raise InputError(f"{path} has no section joint_limits, expected a MoveIt joint_limits.yaml")
    if not set(joints) & set(robot.joint_names):
        raise InputError(
            f"{path} names the joints {', '.join(map(str, joints))}, none of which robot {robot.name!r} has"
        )
    limits: dict[str, Array] = {}
    for index, name in enumerate(robot.joint_names):
        values = joints.get(name)
        if not isinstance(values, dict):
            continue
        entry = _Entry(str(path), name, values)
        for quantity in filter(entry.has, _FILE_NAMES):
            ours = _FILE_NAMES[quantity]
            limits.setdefault(ours, _robots_own(robot, ours))[:, index] = entry.bounds(quantity)
    for quantity in ("velocity", "acceleration"):
        scale = _scaling_factor(str(path), quantity, content)
        if scale != 1.0:
            limits[quantity] = scale * limits.get(quantity, _robots_own(robot, quantity))
    return limits


def _scaling_factor(path: str, quantity: str, content: dict[str, Any]) -> float:
    key = f"default_{quantity}_scaling_factor"
    scale = _number(path, "the file", key, content.get(key, 1.0))
    if not 0.0 < scale <= 1.0:
        raise InputError(f"{path}: {key} is {scale}, expected a number above 0 and at most 1")
    return scale


def _robots_own(robot: Robot, quantity: str) -> Array:
    """Return a copy of the robot's limits (2, n) of a quantity, infinite where it has none."""
    own = getattr(robot, f"{quantity}_limits", None)
    return np.array([[-np.inf] * robot.n, [np.inf] * robot.n]) if own is None else own.copy()


@dataclass(frozen=True)
class _Entry:
    """One joint's section of the file."""

    path: str
    joint: str
    values: dict[str, Any]

    def has(self, quantity: str) -> bool:
        return bool(self.values.get(f"has_{quantity}_limits", False))

    def bounds(self, quantity: str) -> tuple[float, float]:
        top = self._get(f"max_{quantity}")
        low_key = f"min_{quantity}"
        bottom = self._get(low_key) if low_key in self.values or quantity == "position" else -top
        if not bottom <= top or (quantity != "position" and not bottom <= 0.0 <= top):
            raise InputError(
                f"{self.path}: joint {self.joint!r} has {quantity} limits {bottom} and {top}, "
                "expected lower <= upper" + ("" if quantity == "position" else " with zero between them")
            )
        return bottom, top

    def _get(self, key: str) -> float:
        if key not in self.values:
            raise InputError(f"{self.path}: joint {self.joint!r} has no {key} though its switch is on")
        return _number(self.path, f"joint {self.joint!r}", key, self.values[key])


def _number(path: str, where: str, key: str, value: Any) -> float:
    # YAML reads "1e3" as text; a bool is no number here.
    if isinstance(value, str) and re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", value):
        value = float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError(f"{path}: {key} of {where} is {value!r}, expected a finite number")
    return float(value)


def _read(path: Path) -> dict[str, Any]:
    import yaml

    class Loader(yaml.SafeLoader):
        """YAML's safe loader that also knows ROS's angle tags."""

    def angle(scale: float) -> Any:
        return lambda loader, node: scale * float(loader.construct_scalar(node))

    Loader.add_constructor("!degrees", angle(math.pi / 180.0))
    Loader.add_constructor("!radians", angle(1.0))
    try:
        content = yaml.load(path.read_text(encoding="utf-8"), Loader=Loader)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from error
    except (yaml.YAMLError, ValueError) as error:
        raise InputError(f"{path} is no valid YAML: {error}") from error
    if not isinstance(content, dict):
        raise InputError(f"{path} has no section joint_limits, expected a MoveIt joint_limits.yaml")
    return content
