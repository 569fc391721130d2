"""The judge: every answer, ours or published, passes through `audit`."""

from __future__ import annotations

from ocp_traj.audit.judge import audit
from ocp_traj.audit.verdict import Clearance, Extremum, Verdict

__all__ = ["Clearance", "Extremum", "Verdict", "audit"]
