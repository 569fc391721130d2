"""Settings for every test: one thread per process, no display, reproducible property tests; and no accepted motion
may be shorter than its certified lower bound (`helpers.bounds_guard`)."""

from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
os.environ.setdefault("MPLBACKEND", "Agg")

from hypothesis import HealthCheck, settings  # noqa: E402

from helpers.bounds_guard import no_accepted_motion_beats_its_bound  # noqa: E402

__all__ = ["no_accepted_motion_beats_its_bound"]

settings.register_profile(
    "default", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("long", deadline=None, max_examples=5000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))
