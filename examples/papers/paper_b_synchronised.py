"""
Paper B: joints optimised apart
===============================

Paper B minimises the durations of every joint alone and takes the largest of each segment. The result is no safe
motion: a polynomial stretched in one segment overshoots in another. The audit says which joint, when, by how much.
"""

import ocp_traj as ot

task = ot.load_case("machines-2024-490", overrides=['search.protocol="per-joint"'])
apart = ot.solve(task, "pso@paper-b", seed=0, budget=15_000)
print(apart.audit)

# One shared set of durations keeps every limit; the best of them is known with a proof.
shared = ot.load_case("machines-2024-490")
together = ot.solve(shared, "ipopt")
print(
    f"joints apart {apart.duration:.3f} s: not feasible; shared durations {together.duration:.4f} s: feasible"
)

assert not apart.feasible and together.feasible
assert apart.duration < together.duration
