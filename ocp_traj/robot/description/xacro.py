"""xacro, the macro language of robot descriptions: recognised here, expanded by an optional package."""

from __future__ import annotations

import re
from pathlib import Path

from ocp_traj.exceptions import RobotError

_TAG = re.compile(r"<xacro:")
_NAMESPACE = re.compile(r"xmlns:xacro\s*=")
_EXPRESSION = re.compile(r"=\s*[\"'][^\"'<]*\$[{(]")
_COMMENT = re.compile("<!--.*?-->", re.DOTALL)


def is_xacro(path: Path, text: str) -> bool:
    """Return whether a description has to be expanded: its name says so, or a macro or an expression is in it.

    Parameters
    ----------
    path : pathlib.Path
    text : str
        Its content; comments do not count.
    """
    if path.suffix.lower() == ".xacro":
        return True
    plain = _COMMENT.sub("", text)
    expression = _NAMESPACE.search(plain) and _EXPRESSION.search(plain)
    return bool(_TAG.search(plain) or expression)


def expanded_xacro(path: Path) -> str:
    """Return the URDF that a xacro file stands for, its arguments at their defaults.

    Raises
    ------
    RobotError
        The package that expands it is not installed, or it cannot be expanded.
    """
    try:
        import xacro
        from xacrodoc import packages  # finds packages without ROS, and tells xacro
    except ImportError:
        raise RobotError(
            f"robot description {path} is xacro, which `pip install 'ocp-traj[xacro]'` lets this program expand; "
            f"or write a URDF with ROS: `xacro {path.name} > {path.stem.removesuffix('.urdf')}.urdf`"
        ) from None
    try:
        packages.walk_up_from(str(path))
        return xacro.process_file(str(path)).toxml()
    except (Exception, SystemExit) as error:  # whatever the macros do: expressions in them are evaluated
        reason = " ".join(str(error).split()) or type(error).__name__
        raise RobotError(f"robot description {path} is xacro that cannot be expanded: {reason[:300]}") from None
