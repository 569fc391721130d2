"""Mutation testing changes modules that exist, and runs tests that exist."""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest

from helpers.folders import ROOT


@pytest.fixture(scope="module")
def areas() -> dict[str, dict[str, list[str]]]:
    """Return the tables as ``tests/whole/mutation/run.py`` has them."""
    code = "from areas import AREAS; print(AREAS)"
    place = ROOT / "tests" / "whole" / "mutation"
    done = subprocess.run([sys.executable, "-c", code], cwd=place, capture_output=True, text=True, check=True)
    found: dict[str, dict[str, list[str]]] = ast.literal_eval(done.stdout)
    return found


def test_modules_and_tests_of_every_area_exist(areas: dict[str, dict[str, list[str]]]) -> None:
    for modules in areas.values():
        assert len(modules) >= 5
        for module, tests in modules.items():
            assert (ROOT / module).is_file(), module
            assert tests
    for test in {test for modules in areas.values() for tests in modules.values() for test in tests}:
        path, _, name = test.partition("::")
        text = (ROOT / path).read_text(encoding="utf-8")
        assert not name or f"def {name.partition('[')[0]}(" in text, test
