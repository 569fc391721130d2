"""
A proof that anyone can check
=============================

"Feasible" and "no motion is shorter" as files that one small program of standard-library Python checks: it computes
everything again in exact numbers, or with a bound of every rounding error, and believes nothing.
"""

import subprocess
import sys

import ocp_traj as ot
from ocp_traj.proofs import NotProved, check, checker, prove, prove_bound, write_proof

task = ot.load_case("machines-2024-490")
result = ot.solve(task)
document = result.prove()
print(f"{check(document).statement}; the duration should be that of the result, {result.duration:.4f} s")

# %%
# A file for others: they need Python and `checker.py`, nothing of this package.
write_proof(document, "motion.proof.json")
command = [sys.executable, "-I", "-S", checker.__file__, "motion.proof.json"]
done = subprocess.run(command, capture_output=True, text=True, check=False)
print(done.returncode, done.stdout)

# %%
# What is false is not proved, and the sentence says why: the same motion, 0.001 % faster.
try:
    prove(task, result.trajectory.scaled(1 - 1e-5))
    refused = ""
except NotProved as reason:
    refused = str(reason)
print(f"not proved: {refused}")

# %%
# The other direction: no motion whatever through these points is shorter than this.
bound = check(prove_bound(task, duration=1.4))
print(f"{bound.statement}; our motion, {result.duration:.4f} s, should be above it")

assert done.returncode == 0 and done.stdout.startswith("proved: ")
assert "beyond its limit" in refused or "not as asked" in refused
assert bound.kind == "bound" and result.duration > 1.4
