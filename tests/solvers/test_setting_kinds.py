"""A solver's setting of the wrong kind is one sentence: which one, what was given, what was expected."""

from __future__ import annotations

import pytest

from ocp_traj.exceptions import InputError
from ocp_traj.solvers import parse_solver


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "ipopt[iterations=x]",
            "The setting 'iterations' of solver 'ipopt' is 'x', expected a whole number.",
        ),
        (
            "ipopt[iterations=1e3]",
            "The setting 'iterations' of solver 'ipopt' is 1000.0, expected a whole number.",
        ),
        ("ipopt[compiled=3]", "The setting 'compiled' of solver 'ipopt' is 3, expected true or false."),
        ("ipopt-multistart[spread=x]", "'spread' of solver 'ipopt-multistart' is 'x', expected a number."),
        ("pso+ipopt[starts=1.5]", "'starts' of solver 'pso+ipopt' is 1.5, expected a whole number."),
        ("pso+ipopt[population=x]", "'population' of ParticleSwarm is 'x', expected a whole number."),
        ("pso[restarts=x]", "'restarts' of solver 'pso' is 'x', expected true or false."),
        ("pso[encoding=3]", "'encoding' of solver 'pso' is 3, expected a word."),
        ("pso[handling=magic]", "constraint handling is 'magic', expected one of feasible-first"),
        ("pso[handling=3]", "constraint handling is 3, expected one of feasible-first"),
    ],
)
def test_a_setting_of_another_kind_is_refused(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_solver(text)
    assert sentence in str(refused.value)
