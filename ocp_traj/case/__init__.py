"""Case files: one TOML file states one trajectory task. Nothing else in the library reads TOML."""

from __future__ import annotations

from pathlib import Path

from ocp_traj.case.digest import task_digest
from ocp_traj.case.loading import case_names, case_title, load_case, load_case_text
from ocp_traj.case.toml_files import read_toml
from ocp_traj.case.travelling import carried_task, task_from_json, task_to_json
from ocp_traj.case.writing import dumps, write_case

__all__ = [
    "carried_task",
    "case_names",
    "case_template",
    "case_title",
    "dumps",
    "load_case",
    "load_case_text",
    "read_toml",
    "task_digest",
    "task_from_json",
    "task_to_json",
    "write_case",
]


def case_template() -> str:
    """Return the text of a commented case to start from."""
    return (Path(__file__).parent / "template.toml").read_text(encoding="utf-8")
