"""Every public name is documented: what it is, its parameters or fields, and a place in the API reference."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import metaheuristics
import ocp_traj

REFERENCE = Path(__file__).parent.parent / "docs" / "api.md"


def public_names() -> Iterator[tuple[str, str]]:
    """Yield (package, name) of everything in the ``__all__`` of our packages, at its uppermost place only."""
    seen: set[int] = set()
    for package in (ocp_traj, metaheuristics):
        below = pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
        for module in [package.__name__, *(entry.name for entry in below if entry.ispkg)]:
            home = importlib.import_module(module)
            for name in getattr(home, "__all__", ()):
                subject = getattr(home, name)
                if id(subject) not in seen and name != "__version__":
                    seen.add(id(subject))
                    yield module, name


def own_members(cls: type) -> Iterator[tuple[str, Any]]:
    """Yield the public methods and properties a class defines itself."""
    for name, member in vars(cls).items():
        described = (property, classmethod, staticmethod)
        if not name.startswith("_") and (inspect.isfunction(member) or isinstance(member, described)):
            yield name, getattr(cls, name)


def section(text: str, *titles: str) -> str:
    """Return the NumPy sections with these titles, without their descriptions' indented lines."""
    found = re.findall(
        rf"^(?:{'|'.join(titles)})\n-+\n(.*?)(?=\n\n\S[^\n]*\n---|\Z)", text, re.DOTALL | re.MULTILINE
    )
    return "\n".join(line for part in found for line in part.splitlines() if not line.startswith(" "))


def undescribed(text: str, names: list[str]) -> list[str]:
    """Return the names that no section of a docstring describes."""
    described = section(text, "Parameters", "Attributes")
    return [name for name in names if not re.search(rf"(^|[ *,]){name}\b", described, re.MULTILINE)]


def subject_of(package: str, name: str) -> Any:
    """Return what a public name stands for."""
    return getattr(importlib.import_module(package), name)


NAMES = sorted(public_names())
FUNCTIONS = [pair for pair in NAMES if inspect.isfunction(subject_of(*pair))]
CLASSES = [pair for pair in NAMES if inspect.isclass(subject_of(*pair))]
RECORDS = [pair for pair in CLASSES if dataclasses.is_dataclass(subject_of(*pair))]


@pytest.mark.parametrize("package, name", FUNCTIONS + CLASSES)
def test_a_function_or_class_says_what_it_is(package: str, name: str) -> None:
    subject = subject_of(package, name)
    text = inspect.getdoc(subject) or ""
    assert len(text.split()) >= 3 and "." in text
    if inspect.isclass(subject):
        assert subject.__doc__, "inherited"
        for member, described in own_members(subject):
            assert inspect.getdoc(described), member


@pytest.mark.parametrize("package, name", FUNCTIONS)
def test_a_function_describes_its_parameters_and_its_answer(package: str, name: str) -> None:
    subject = subject_of(package, name)
    text = inspect.getdoc(subject) or ""
    signature = inspect.signature(subject)
    assert not undescribed(text, [parameter.strip("*") for parameter in signature.parameters])
    answers_nothing = signature.return_annotation in (None, "None")
    assert answers_nothing or section(text, "Returns") or text.startswith("Return ")


@pytest.mark.parametrize("package, name", RECORDS)
def test_a_record_describes_its_fields(package: str, name: str) -> None:
    subject = subject_of(package, name)
    own = vars(subject).get("__annotations__", {})  # inherited fields are described where they are declared
    fields = [field.name for field in dataclasses.fields(subject) if field.name in own]
    assert not undescribed(
        inspect.getdoc(subject) or "", [name for name in fields if not name.startswith("_")]
    )


@pytest.mark.parametrize("package, name", NAMES)
def test_a_public_name_has_a_place_in_the_reference(package: str, name: str) -> None:
    reference = REFERENCE.read_text(encoding="utf-8")
    if package == "metaheuristics":
        assert ".. automodule:: metaheuristics" in reference
        return
    shown = name if package == "ocp_traj" else rf"{re.escape(package)}\.{name}"
    assert re.search(rf"^\.\. (?:auto\w+|py:data):: {shown}$", reference, re.MULTILINE), f"{package}.{name}"
