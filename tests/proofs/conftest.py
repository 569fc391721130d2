"""Proofs that several tests look at."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.fixture(scope="session")
def bounds() -> dict[tuple[str, str], dict[str, Any]]:
    """Proofs of lower bounds by case and by what they are of."""
    import ocp_traj as ot
    from ocp_traj.proofs import prove_bound

    claims = {
        ("machines-2024-490", "every motion"): 1.4809,
        ("fanuc-m10id8l", "every motion"): 0.7198,
        ("machines-2024-490", "3-5-3"): 4.3061,
        ("fanuc-m10id8l", "3-5-3"): 1.2230,
    }
    return {
        key: prove_bound(ot.load_case(key[0]), 600.0, duration=duration, of=key[1])  # type: ignore[arg-type]
        for key, duration in claims.items()
    }
