import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from metaheuristics import Checkpoint, SparrowSearch, make_optimizer, minimize, registry
from metaheuristics.test_problems.standard import Rastrigin

REPOSITORY = Path(__file__).parents[2]


def make_problem():
    return Rastrigin(3, half_width=5.12, shift=[1.0, -2.0, 3.0])


class Killed(Exception):
    pass


def run(optimizer, path=None, *, kill_at=None, seed=3, every=4, rule=None):
    def callback(progress):
        if progress.generation == kill_at:
            raise Killed

    return minimize(
        make_problem(),
        optimizer,
        budget=500,
        rng=np.random.default_rng(seed),
        callback=callback,
        checkpoint=None if path is None else Checkpoint(path, every=every),
        constraint_handling=rule,
    )


def assert_same(one, other):
    assert (one.history.x == other.history.x).all()
    assert (one.history.cost == other.history.cost).all()
    assert (one.history.evaluations == other.history.evaluations).all()
    assert (one.history.spread == other.history.spread).all()
    assert one.evaluations == other.evaluations
    assert one.message == other.message


@pytest.mark.parametrize("name", sorted(registry))
def test_a_killed_run_goes_on_as_if_nothing_had_happened(name, tmp_path):
    optimizer = make_optimizer(name, population=12)
    path = tmp_path / "run.npz"
    with pytest.raises(Killed):
        run(optimizer, path, kill_at=14)
    resumed = run(optimizer, path, seed=99)  # the generator's state comes from the file
    assert_same(resumed, run(optimizer))
    assert resumed.history.seconds[-1] > 0.0
    assert (np.diff(resumed.history.seconds) >= 0.0).all()


@pytest.mark.parametrize("rule", ["epsilon", "adaptive-penalty"])
def test_rules_that_change_with_time_are_resumed_as_they_were(rule, tmp_path):
    optimizer = SparrowSearch(population=12)
    with pytest.raises(Killed):
        run(optimizer, tmp_path / "run.npz", kill_at=14, rule=rule)
    assert_same(run(optimizer, tmp_path / "run.npz", rule=rule), run(optimizer, rule=rule))


def test_a_finished_run_is_not_repeated(tmp_path):
    optimizer = replace(SparrowSearch(population=12), scouts=0.0)
    path = tmp_path / "run.npz"
    first = minimize(make_problem(), optimizer, generations=9, rng=np.random.default_rng(0), checkpoint=path)
    calls = []
    again = minimize(
        make_problem(),
        optimizer,
        generations=9,
        rng=np.random.default_rng(0),
        checkpoint=str(path),
        callback=calls.append,
    )
    assert_same(first, again)
    assert calls == []


def test_a_process_killed_for_good_leaves_a_file_to_go_on_from(tmp_path):
    path = tmp_path / "run.npz"
    code = f"""
import os, signal
import numpy as np
from metaheuristics import Checkpoint, ParticleSwarm, minimize
from metaheuristics.test_problems.standard import Rastrigin
def callback(progress):
    if progress.generation == 23:
        os.kill(os.getpid(), signal.SIGKILL)
minimize(Rastrigin(3, half_width=5.12, shift=[1.0, -2.0, 3.0]), ParticleSwarm(population=12), budget=500,
         rng=np.random.default_rng(3), callback=callback, checkpoint=Checkpoint({str(path)!r}, every=4))
"""
    ended = subprocess.run([sys.executable, "-c", code], cwd=REPOSITORY, check=False)
    assert ended.returncode == -9
    optimizer = make_optimizer("pso-constriction", population=12)
    assert_same(run(optimizer, path), run(optimizer))
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("kind", [np.random.PCG64, np.random.MT19937, np.random.SFC64])
def test_every_kind_of_generator_is_restored(kind, tmp_path):
    optimizer = SparrowSearch(population=12)

    def go(path, seed, stop=None):
        def callback(progress):
            if progress.generation == stop:
                raise Killed

        rng = np.random.Generator(kind(seed))
        checkpoint = Checkpoint(path, every=3)
        return minimize(
            make_problem(), optimizer, generations=10, rng=rng, checkpoint=checkpoint, callback=callback
        )

    with pytest.raises(Killed):
        go(tmp_path / "a.npz", 1, stop=7)
    assert_same(go(tmp_path / "a.npz", 2), go(tmp_path / "b.npz", 1))


def test_a_file_of_another_run_or_generator_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    run(SparrowSearch(population=12), path)
    with pytest.raises(ValueError, match="belongs to another problem, optimiser or constraint handling"):
        run(SparrowSearch(population=13), path)
    with pytest.raises(ValueError, match="belongs to another"):
        run(SparrowSearch(population=12), path, rule="epsilon")
    with pytest.raises(ValueError, match="made with PCG64, given is MT19937"):
        minimize(
            make_problem(),
            SparrowSearch(population=12),
            budget=500,
            rng=np.random.Generator(np.random.MT19937(0)),
            checkpoint=path,
        )


def test_checkpoints_hold_no_pickle(tmp_path):
    path = tmp_path / "run.npz"
    run(make_optimizer("pso", population=12), path)
    with np.load(path, allow_pickle=False) as stored:
        assert all(stored[name].dtype.kind in "fiub" for name in stored.files)


def test_a_checkpoint_needs_a_positive_interval():
    with pytest.raises(ValueError, match="every 0 generations"):
        Checkpoint("run.npz", every=0)
