"""
IPOPT against sparrow search and particle swarm
===============================================

Paper B's problem: 3-5-3 polynomials, four waypoints, shared durations. Every solver gets the same problem and
the same judge; the populations get 3000 evaluations. One run each shows how to ask, not who wins: that takes
many seeds and a test, which ``ocp-traj compare`` does.
"""

import matplotlib.pyplot as plt

import ocp_traj as ot

task = ot.load_case("machines-2024-490")
figure, axis = plt.subplots(layout="constrained", figsize=(7, 4))
results = {}
for name in ("ipopt", "pso", "ssa", "ssa-debiased"):
    result = results[name] = ot.solve(task, name, seed=0, budget=3000)
    verdict = "feasible" if result.feasible else "not feasible"
    spent = result.solution.evaluations
    print(
        f"{name}: {result.duration:.4f} s, {verdict}, {spent} evaluations; should be 4.3104 s or a little more"
    )
    history = result.solution.history
    axis.step(history.evaluations, history.cost, where="post", label=name)

# %%
# The populations' cost counts their best candidate so far; a value below 4.3104 s belongs to one that breaks a
# limit, which the ordering prefers only while none is feasible.
axis.axhline(4.3104, color="black", linewidth=0.8)
axis.set(xlabel="evaluations", ylabel="best duration so far, s", ylim=(3.5, 8.0), xscale="log")
axis.legend()

assert all(result.feasible for result in results.values())
assert min(result.duration for result in results.values()) > 4.3103
