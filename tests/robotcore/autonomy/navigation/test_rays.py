from __future__ import annotations

import math

import numpy as np

from robotcore.autonomy.navigation.rays import hidden, rays_from

MIDDLE = np.array([[5, 5]])
RADII = np.array([1, 2, 3])


def test_rays_go_along_columns_and_rows() -> None:
    rays = rays_from(MIDDLE, np.array([0.0, math.pi / 2, math.pi]), RADII, 11)
    assert rays.rows[0].tolist() == [[5, 5, 5], [6, 7, 8], [5, 5, 5]]
    assert rays.columns[0].tolist() == [[6, 7, 8], [5, 5, 5], [4, 3, 2]]
    assert rays.inside.all()


def test_each_start_has_its_rays() -> None:
    rays = rays_from(np.array([[5, 5], [2, 3]]), np.array([0.0]), RADII, 11)
    assert rays.rows.shape == (2, 1, 3)
    assert (rays.rows[1, 0, 0], rays.columns[1, 0, 0]) == (2, 4)


def test_outside_the_grid_there_is_nothing() -> None:
    rays = rays_from(MIDDLE, np.array([0.0]), np.array([4, 5, 6]), 11)
    assert rays.inside[0, 0].tolist() == [True, True, False]
    assert rays.of(np.ones((11, 11), np.bool_))[0, 0].tolist() == [True, True, False]


def test_what_hides_hides_itself_and_all_behind() -> None:
    hides = np.array([[[False, True, False], [False, False, False]]])
    assert hidden(hides).tolist() == [[[False, True, True], [False, False, False]]]
