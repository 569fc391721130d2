"""Proofs that anyone can check: that a motion keeps every limit at every instant, and that none is shorter.

`prove` and `prove_bound` make proofs, `write_proof` writes them; `check_file` (or ``python checker.py FILE``, one file
of standard-library Python) checks them without any other part of this package.
"""

from __future__ import annotations

from ocp_traj.proofs.bound_proof import prove_bound
from ocp_traj.proofs.checker import NotAProof, Refused, Report, check, check_file
from ocp_traj.proofs.motion_proof import prove
from ocp_traj.proofs.not_proved import NotProved
from ocp_traj.proofs.proof_file import write_proof
from ocp_traj.proofs.resolve import is_about

__all__ = [
    "NotAProof",
    "NotProved",
    "Refused",
    "Report",
    "check",
    "check_file",
    "is_about",
    "prove",
    "prove_bound",
    "write_proof",
]
