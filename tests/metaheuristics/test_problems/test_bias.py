import numpy as np
import pytest
from scipy import stats

from metaheuristics import (
    ParticleSwarm,
    RandomSearch,
    SparrowSearch,
    make_optimizer,
    measure_shift_dependence,
    measure_structural_bias,
)
from metaheuristics.test_problems.bias import (
    find_diagonal_p_value,
    find_kolmogorov_p_value,
    measure_uniform_distance,
)

FAIR = {"debiased": True, "bounds": "reflect"}


def make_rng(seed=0):
    return np.random.default_rng(seed)


def test_the_distance_from_uniform_and_its_p_value_agree_with_scipy():
    for seed, power in ((0, 1.0), (1, 1.2), (2, 2.0)):
        numbers = make_rng(seed).random(150) ** power
        reference = stats.kstest(numbers, "uniform")
        assert measure_uniform_distance(numbers) == pytest.approx(reference.statistic, rel=1e-12)
        assert find_kolmogorov_p_value(reference.statistic, 150) == pytest.approx(
            reference.pvalue, rel=0.02, abs=1e-4
        )
    assert find_kolmogorov_p_value(1e-4, 100) == 1.0


def test_the_diagonal_is_seen_as_correlation():
    unit = make_rng().random((100, 3))
    assert find_diagonal_p_value(unit) > 0.05
    assert find_diagonal_p_value(unit[:, [0, 0]] + 0.1 * unit[:, 1:]) < 1e-10
    assert find_diagonal_p_value(unit[:, :1]) == 1.0


PUBLISHED = {
    "literal": {},
    "scalar": {"beta": "scalar"},
    "per-coordinate": {"alpha": "coordinate", "normal": "coordinate"},
    "flight-coordinate": {"flight": "coordinate"},
    "flight-undivided": {"flight": "coordinate-undivided"},
    "always": {"replacement": "always"},
    "scroungers": {"hungry": "scroungers"},
}


@pytest.mark.parametrize("settings", PUBLISHED.values(), ids=PUBLISHED)
def test_every_published_reading_is_structurally_biased(settings):
    optimizer = SparrowSearch(population=30, **settings)
    report = measure_structural_bias(optimizer, rng=make_rng(1), runs=100, dimension=3, budget=1500)
    assert report.p_value < 1e-6
    assert report.is_biased()
    assert report.positions.shape == (100, 3)


@pytest.mark.parametrize("name", ["t-ssa", "adf-ssa", "tadf-ssa", "issa-a", "issa-b"])
def test_the_published_improvements_are_biased_as_well(name):
    optimizer = make_optimizer(name, population=30)
    report = measure_structural_bias(optimizer, rng=make_rng(1), runs=60, dimension=3, budget=1500)
    assert report.p_value < 1e-3
    assert report.diagonal_p_value < 1e-6


def test_reflecting_walls_do_not_cure_the_diagonal():
    optimizer = SparrowSearch(population=30, bounds="reflect")
    report = measure_structural_bias(optimizer, rng=make_rng(1), runs=60, dimension=3, budget=1500)
    assert report.diagonal_p_value < 1e-6
    assert report.is_biased()


@pytest.mark.parametrize(
    "name", ["ssa-debiased", "tadf-ssa-debiased", "issa-a-debiased", "issa-b-debiased", "random"]
)
def test_debiased_versions_end_anywhere_and_on_no_diagonal(name):
    optimizer = make_optimizer(name, population=30)
    report = measure_structural_bias(optimizer, rng=make_rng(1), runs=80, dimension=3, budget=900)
    assert not report.is_biased(0.01)


@pytest.mark.parametrize(
    "name", ["ssa-debiased", "tadf-ssa-debiased", "issa-a-debiased", "issa-b-debiased", "pso", "de"]
)
def test_unbiased_searches_do_not_notice_where_the_box_is(name):
    near = measure_structural_bias(make_optimizer(name, population=12), rng=make_rng(2), runs=4, budget=300)
    far = measure_structural_bias(
        make_optimizer(name, population=12), rng=make_rng(2), runs=4, budget=300, lower=1000.0, upper=1016.0
    )
    assert far.positions == pytest.approx(near.positions, abs=1e-9)


@pytest.fixture(scope="module")
def published():
    # 10-D sphere in +-100, 20 000 evaluations, 20 runs; the shift is drawn anew for every run.
    return measure_shift_dependence(SparrowSearch(), rng=make_rng(1))


@pytest.fixture(scope="module")
def scalar():
    return measure_shift_dependence(SparrowSearch(beta="scalar"), rng=make_rng(1))


@pytest.fixture(scope="module")
def debiased():
    return measure_shift_dependence(SparrowSearch(**FAIR), rng=make_rng(1))


def is_easier(one, other):
    return stats.mannwhitneyu(one, other, alternative="less").pvalue < 0.01


@pytest.mark.parametrize("reading", ["published", "scalar"])
def test_published_sparrow_search_finds_the_origin_and_misses_everything_else(reading, request):
    found = request.getfixturevalue(reading)
    assert found["origin"].max() < 1e-100
    assert found["random"].min() > 1e-4


def test_a_scalar_beta_collapses_the_flock_onto_the_diagonal(published, scalar):
    assert np.median(scalar["random"]) > 1.0
    assert is_easier(published["random"], scalar["random"])


def test_published_sparrow_search_prefers_the_diagonal(published):
    assert is_easier(published["equal"], published["random"])


def test_debiased_sparrow_search_prefers_neither_the_origin_nor_the_diagonal(debiased):
    assert not is_easier(debiased["origin"], debiased["random"])
    assert not is_easier(debiased["equal"], debiased["random"])


def test_debiased_sparrow_search_is_better_away_from_origin_and_diagonal(published, scalar, debiased):
    assert is_easier(debiased["random"], published["random"])
    for place in ("equal", "random"):
        assert is_easier(debiased[place], scalar[place])


def test_particle_swarm_and_random_search_bracket_them_on_shifted_spheres():
    swarm = measure_shift_dependence(ParticleSwarm(population=50), rng=make_rng(3), runs=5)
    chance = measure_shift_dependence(RandomSearch(), rng=make_rng(3), runs=5)
    assert np.median(swarm["random"]) < 1e-8
    assert np.median(chance["random"]) > 1000.0
