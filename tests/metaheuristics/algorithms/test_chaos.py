import math

import numpy as np
import pytest

from metaheuristics.algorithms.chaos import (
    draw_logistic,
    draw_logistic_sine,
    draw_tent,
    measure_uniformity,
    step_logistic_sine,
)


def test_tent_steps_by_hand(scripted):
    # x = 0.3 -> 0.6 + 0.5/2 = 0.85 -> 2 (0.15) + 0.9/2 = 0.75; x = 0.7 -> 0.6 + 0.25 -> ... the same.
    orbits = draw_tent(2, 2, scripted(random=[[0.3, 0.7], [[0.5, 0.5], [0.9, 0.9]]]))
    assert orbits == pytest.approx(np.array([[0.85, 0.75], [0.85, 0.75]]))


def test_the_kick_wraps_around(scripted):
    assert draw_tent(1, 1, scripted(random=[[0.45], [[0.5]]]))[0, 0] == pytest.approx(0.4)  # 0.9 + 0.5 - 1


def test_a_logistic_step_by_hand(scripted):
    assert draw_logistic(2, scripted(uniform=[0.2])) == pytest.approx([0.64, 4 * 0.64 * 0.36])


def test_a_logistic_sine_step_by_hand_in_both_readings():
    a, x, y = 0.9, 0.3, 0.6
    first = abs(math.sin(math.pi * (3.6 * 0.21 + 0.1 * math.sin(0.6 * math.pi))))
    plain = abs(math.sin(math.pi * (3.6 * 0.24 + 0.1 * math.sin(math.pi * first))))
    squared = abs(math.sin(math.pi * (3.6 * 0.24 + 0.1 * math.sin(math.pi * first**2))))
    assert step_logistic_sine(x, y, a) == (pytest.approx(first), pytest.approx(plain))
    assert step_logistic_sine(x, y, a, squared=True) == (pytest.approx(first), pytest.approx(squared))
    assert plain != pytest.approx(squared)


def test_orbits_alternate_x_and_y_of_the_two_dimensional_map(scripted):
    orbit = draw_logistic_sine(5, scripted(uniform=[0.3, 0.6]))
    point = step_logistic_sine(0.3, 0.6, 0.9)
    after = step_logistic_sine(*point, 0.9)
    assert orbit[:4] == pytest.approx([*point, *after])
    assert orbit.shape == (5,)


def test_uniformity_counts_bins_and_measures_their_deviation():
    counts, chi_square = measure_uniformity(np.array([0.05, 0.05, 0.15, 1.0]), bins=10)
    assert counts.tolist() == [2, 1, 0, 0, 0, 0, 0, 0, 0, 1]
    assert chi_square == pytest.approx(((2 - 0.4) ** 2 + 2 * (1 - 0.4) ** 2 + 7 * 0.4**2) / 0.4)


def test_a_thousand_numbers_in_ten_bins_as_in_figure_1_of_paper_c():
    # Quantiles of chi square with 9 degrees of freedom: 0.1 % is 1.15, 99.9 % is 27.9.
    results = {}
    for name, draw in {
        "tent": lambda rng: draw_tent(1, 1000, rng)[0],
        "logistic": lambda rng: draw_logistic(1000, rng),
        "logistic-sine": lambda rng: draw_logistic_sine(1000, rng),
        "pseudo-random": lambda rng: rng.random(1000),
    }.items():
        results[name] = np.array([measure_uniformity(draw(np.random.default_rng(s)))[1] for s in range(50)])
    # The paper's claim holds for Tent, barely: it is at least as even as pseudo-random numbers in the median.
    assert np.median(results["tent"]) <= np.median(results["pseudo-random"])
    assert 6.0 < np.median(results["pseudo-random"]) < 11.0
    # The logistic map crowds at both ends, the logistic-sine map of paper B near 1, whatever the seed.
    assert results["logistic"].min() > 27.9
    assert results["logistic-sine"].min() > 27.9


def test_maps_stay_in_the_unit_interval_and_do_not_collapse():
    for seed in range(20):
        for numbers in (
            draw_tent(1, 2000, np.random.default_rng(seed))[0],
            draw_logistic(2000, np.random.default_rng(seed)),
            draw_logistic_sine(2000, np.random.default_rng(seed)),
            draw_logistic_sine(2000, np.random.default_rng(seed), squared=True),
        ):
            assert numbers.min() >= 0.0
            assert numbers.max() <= 1.0
            assert np.unique(numbers[-100:]).size > 90
