"""An XML file of a robot as a tree: found, decoded, expanded where it is xacro, and refused in one sentence."""

from __future__ import annotations

import codecs
import re
from pathlib import Path
from xml.etree import ElementTree

from ocp_traj.exceptions import RobotError
from ocp_traj.robot.description.xacro import expanded_xacro, is_xacro

MAX_BYTES = 100_000_000
"""Largest description that is read, bytes; meshes are files of their own."""

_DECLARED = re.compile(rb"""^\s*<\?xml[^>]*\bencoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")


def read_document(path: Path, what: str = "URDF") -> ElementTree.Element:
    """Return the root ``robot`` of a URDF or SRDF file; xacro is expanded.

    Text that is not UTF-8 is read as the file declares, else as Latin-1. Entities are neither expanded nor fetched.

    Parameters
    ----------
    path : pathlib.Path
    what : str
        "URDF" or "SRDF", for messages.

    Raises
    ------
    RobotError
        The file is missing, too large, empty or no such document, or it is xacro and cannot be expanded.
    """
    text = _read_text(path)
    if not text.strip():
        raise RobotError(f"robot description {path} is empty, expected a {what}")
    if "<!ENTITY" in text:
        raise RobotError(f"robot description {path} defines XML entities, expected plain XML")
    if is_xacro(path, text):
        text = expanded_xacro(path)
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise RobotError(f"robot description {path} is not a valid {what}: {error}") from None
    if root.tag != "robot":
        raise RobotError(
            f"robot description {path} is not a valid {what}: its root is <{root.tag[:40]}>, expected <robot>"
        )
    return root


def _read_text(path: Path) -> str:
    try:
        if not path.is_file():
            raise RobotError(f"robot description {path} does not exist")
        if path.stat().st_size > MAX_BYTES:
            raise RobotError(f"robot description {path} is larger than {MAX_BYTES} bytes")
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, RobotError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise RobotError(f"robot description {path} cannot be read: {reason}") from None
    text = _decoded(content)
    # A declaration of the encoding has done its work; the parser refuses some in text that is decoded already.
    return re.sub(r"^\s*<\?xml[^>]*\?>", "", text, count=1)


def _decoded(content: bytes) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    declared = _DECLARED.match(content)
    for encoding in ("utf-8-sig", declared[1].decode("ascii") if declared else "latin-1"):
        try:
            return content.decode(encoding)
        except (UnicodeDecodeError, LookupError):
            continue
    return content.decode("latin-1")  # every byte is a character there
