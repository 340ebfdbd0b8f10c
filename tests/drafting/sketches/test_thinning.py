import numpy as np
from scipy import ndimage

from lidardraft.drafting.sketches.thinning import branch_points, thinned

EIGHT = np.ones((3, 3))


def test_a_thick_bar_becomes_its_middle_line() -> None:
    mask = np.zeros((20, 60), dtype=bool)
    mask[5:14, 4:56] = True
    thin = thinned(mask)
    rows, columns = np.nonzero(thin)
    assert set(rows[(columns > 12) & (columns < 48)]) == {9}
    assert not branch_points(thin)[:, 15:45].any()


def test_what_is_in_one_piece_stays_in_one_piece_with_its_holes() -> None:
    rng = np.random.default_rng(0)
    mask = ndimage.gaussian_filter(rng.normal(size=(120, 120)), 4) > 0
    mask[[0, -1]] = mask[:, [0, -1]] = False
    thin = thinned(mask)
    assert thin.sum() < 0.2 * mask.sum()
    assert not (thin & ~mask).any()
    assert ndimage.label(thin, EIGHT)[1] == ndimage.label(mask, EIGHT)[1]
    assert (
        ndimage.label(np.pad(~thin, 1, constant_values=True))[1]
        == ndimage.label(np.pad(~mask, 1, constant_values=True))[1]
    )


def test_lines_that_meet_have_a_branch_point_there() -> None:
    mask = np.zeros((41, 41), dtype=bool)
    mask[18:23] = mask[:, 18:23] = True
    down, right = np.nonzero(branch_points(thinned(mask)))
    assert len(down)
    assert np.abs(down - 20).max() <= 3
    assert np.abs(right - 20).max() <= 3
