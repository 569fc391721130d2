"""A setting of the wrong kind is refused in one sentence: which one, what was given, what was expected."""

from __future__ import annotations

import numpy as np
import pytest

from metaheuristics import make_optimizer, registry


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("population", "text", "a whole number"),
        ("population", 50.0, "a whole number"),
        ("population", True, "a whole number"),
        ("population", None, "a whole number"),
        ("weight", "text", "a number"),
        ("weight", float("nan"), "a number"),
        ("weight", False, "a number"),
        ("bounds", 3, "a word"),
    ],
)
def test_a_value_of_another_kind_is_refused(key: str, value: object, expected: str) -> None:
    with pytest.raises(ValueError) as refused:
        make_optimizer("pso", **{key: value})
    assert str(refused.value) == (f"The setting {key!r} of ParticleSwarm is {value!r}, expected {expected}.")


def test_true_and_false_are_no_words() -> None:
    with pytest.raises(ValueError, match="'debiased' of SparrowSearch is 'yes', expected true or false"):
        make_optimizer("ssa", debiased="yes")


@pytest.mark.parametrize("name", registry)
def test_every_optimiser_checks_its_population(name: str) -> None:
    with pytest.raises(ValueError, match=r"'population' of .* is 'text', expected a whole number"):
        make_optimizer(name, population="text")


def test_numbers_of_numpy_are_numbers() -> None:
    made = make_optimizer("pso", population=np.int64(7), weight=np.float32(0.5), social=1)
    assert (made.population, made.weight, made.social) == (7, 0.5, 1)
    assert make_optimizer("ssa", debiased=np.True_).debiased


def test_the_command_line_names_setting_value_and_kind(capsys: pytest.CaptureFixture[str]) -> None:
    from ocp_traj.cli.main import run

    assert run(["solve", "fang-2020-task-1", "--solver", "pso[population=text]"]) == 2
    words = capsys.readouterr().err
    assert words == (
        "ocp-traj: solver 'pso': The setting 'population' of ParticleSwarm is 'text', expected a whole number.\n"
    )
