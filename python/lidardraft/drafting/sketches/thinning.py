"""A mask of thick strokes becomes lines one pixel wide: Guo and Hall, "Parallel thinning with two-subiteration
algorithms", Communications of the ACM 1989."""

from __future__ import annotations

import numpy as np

# Around a pixel, from above it on clockwise: down and right.
AROUND = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))


def _tables() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By the code of the pixels around one: whether it goes in the first and the second step, and how many are set."""
    codes = np.arange(256)
    bits = ((codes[:, None] >> np.arange(8)) & 1).astype(bool)
    n, ne, e, se, s, sw, w, nw = bits.T
    pieces = sum((~a & (b | c)).astype(int) for a, b, c in ((n, ne, e), (e, se, s), (s, sw, w), (w, nw, n)))
    pairs = [
        sum((a | b).astype(int) for a, b in pairs)
        for pairs in (((nw, n), (ne, e), (se, s), (sw, w)), ((n, ne), (e, se), (s, sw), (w, nw)))
    ]
    count = np.minimum(*pairs)
    removable = (pieces == 1) & (count >= 2) & (count <= 3)
    return removable & ~((s | sw | ~nw) & w), removable & ~((n | ne | ~se) & e), bits.sum(axis=1)


_FIRST, _SECOND, _COUNT = _tables()


def thinned(mask: np.ndarray) -> np.ndarray:
    """The middle lines bool [H, W] of a mask bool [H, W]."""
    thin = np.pad(mask, 1)
    while True:
        before = np.count_nonzero(thin)
        for table in (_FIRST, _SECOND):
            thin &= ~table[_codes(thin)]
        if np.count_nonzero(thin) == before:
            inner: np.ndarray = thin[1:-1, 1:-1]
            return inner


def branch_points(thin: np.ndarray) -> np.ndarray:
    """Where lines of one pixel meet, bool [H, W]."""
    codes = _codes(np.pad(thin, 1))[1:-1, 1:-1]
    meeting: np.ndarray = thin & (_COUNT[codes] >= 3)
    return meeting


def _codes(thin: np.ndarray) -> np.ndarray:
    """Which of the pixels around each are set, as bits; none are around those at the edge."""
    codes = np.zeros(thin.shape, dtype=np.uint8)
    for bit, (down, right) in enumerate(AROUND):
        codes[1:-1, 1:-1] |= (
            thin[1 + down : thin.shape[0] - 1 + down, 1 + right : thin.shape[1] - 1 + right].view(np.uint8) << bit
        )
    return codes
