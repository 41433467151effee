import numpy as np

from ssjs_cli.report.submap_colours import PALETTE, colour_groups


def test_the_first_ten_submaps_have_ten_colours():
    assert colour_groups(np.column_stack((np.arange(10.0), np.zeros(10)))) == list(range(len(PALETTE)))


def test_the_eleventh_takes_the_colour_farthest_away():
    # ten bases on a line at x = 0..9, the next at x = 8.4: the base at 0 is farthest
    base = np.column_stack((np.append(np.arange(10.0), 8.4), np.zeros(11)))
    assert colour_groups(base)[10] == 0


def test_no_submap_shares_the_colour_of_its_nearest_neighbour():
    rng = np.random.default_rng(5)
    base = rng.uniform(0.0, 300.0, (200, 2))
    groups = colour_groups(base)
    for index in range(200):
        distance = np.hypot(*(base - base[index]).T)
        distance[index] = np.inf
        assert groups[index] != groups[int(np.argmin(distance))]


def test_no_submaps():
    assert colour_groups(np.zeros((0, 2))) == []
