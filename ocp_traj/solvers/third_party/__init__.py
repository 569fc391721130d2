"""Optimisers of other packages behind the same interface."""

from __future__ import annotations

from ocp_traj.solvers.third_party.third_party import ThirdParty

__all__ = ["ThirdParty"]
