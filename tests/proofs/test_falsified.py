"""Proofs of false statements are refused: each is first shown false by another measure than the checker's."""

from __future__ import annotations

import copy
import json
from collections import Counter
from typing import Any

import numpy as np
import pytest

from helpers.proofs.falsify import KINDS
from helpers.proofs.measure import falsehood
from helpers.proofs.proof_motions import kinematic_motion, torque_motion
from ocp_traj.proofs import Refused, check, prove
from ocp_traj.task import Limits, Objective

EACH = 8
"""Falsified proofs of a kind."""


@pytest.fixture(scope="module")
def true_proofs() -> list[dict[str, Any]]:
    """Proofs of small motions with every kind of limit and cost."""
    found = []
    for seed in (21, 38):
        task, motion = kinematic_motion(seed)
        near = 1.05 * np.abs(motion(np.linspace(0.0, motion.duration, 500))).max(axis=0)
        limits = {name: task.limits.get(name)[0] for name in ("velocity", "acceleration", "jerk")}
        task = task.changed(
            limits=Limits(position=near, **limits), objective=Objective(time=1.0, jerk=0.1, acceleration=0.1)
        )
        found.append(prove(task, motion))
    for seed in (21, 37, 56):
        found.append(prove(*torque_motion(seed, friction=1.0, rate=True, weights={"energy": 1.0})))
    assert all(not falsehood(proof) for proof in found)
    return found


def falsified(proofs: list[dict[str, Any]], kind: str) -> list[tuple[str, dict[str, Any]]]:
    """Return proofs changed in one way, with what is false about each."""
    rng = np.random.default_rng(sorted(KINDS).index(kind))
    found: list[tuple[str, dict[str, Any]]] = []
    for trial in range(6 * EACH):
        document = copy.deepcopy(proofs[trial % len(proofs)])
        KINDS[kind](document, rng)
        reason = falsehood(document) if document not in proofs else ""
        if reason:
            found.append((reason, document))
        if len(found) == EACH:
            break
    return found


def test_two_hundred_false_statements_of_twenty_kinds_are_refused(true_proofs: list[dict[str, Any]]) -> None:
    refused: Counter[str] = Counter()
    for kind in KINDS:
        for reason, document in falsified(true_proofs, kind):
            try:
                report = check(json.loads(json.dumps(document)))
            except Refused:
                refused[kind] += 1
            else:
                pytest.fail(f"{kind}: {reason} is false, but: {report.statement}")
    assert sum(refused.values()) >= 200
    assert len(refused) >= 25, sorted(set(KINDS) - set(refused))
