"""What a receiver makes of the sub-rays of a beam: echoes that come together are one, and one echo is reported."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(slots=True, eq=False)
class Echoes:
    """The echo of each beam, f32 [H, W]: its range `depth` [m], 0 where there is none, and its `power`.

    `mixed` [N] are the pixels whose sub-rays met several primitives, `winner` [N] the sub-rays that brought most of
    their echoes, as flat indices into images [H, W] and [H, S, W]; elsewhere the sub-rays are alike. Effects change
    depth and power in place.
    """

    depth: np.ndarray
    power: np.ndarray
    mixed: np.ndarray
    winner: np.ndarray


def mixed_pixels(depth: np.ndarray, primitive: np.ndarray, pulse_length: float) -> np.ndarray:
    """Flat indices [N] into images [H, W]: beams whose sub-rays, of images [H, S, W], met more than one thing."""
    nearest, furthest = depth[:, 0].copy(), depth[:, 0].copy()
    mixed = np.zeros(nearest.shape, bool)
    for s in range(1, depth.shape[1]):
        np.minimum(nearest, depth[:, s], out=nearest)
        np.maximum(furthest, depth[:, s], out=furthest)
        mixed |= primitive[:, s] != primitive[:, 0]
    furthest -= nearest
    mixed |= furthest > np.float32(pulse_length)
    return np.flatnonzero(mixed)


def receive(
    depth: np.ndarray,
    power: np.ndarray,
    primitive: np.ndarray,
    *,
    pulse_length: float,
    last: bool = False,
    mixed: np.ndarray | None = None,
) -> Echoes:
    """One echo a beam out of sub-rays [H, S, W], of which each brings its share of the `power` over the threshold.

    Sub-rays whose ranges lie within `pulse_length` [m] of each other make one echo at their mean range, weighted by
    power: a mixed pixel at the edge of a thing. Of several echoes the strongest counts, or the `last` of those above
    the threshold. `mixed` are the `mixed_pixels`, where they are known already.
    """
    if depth.shape[1] == 1:
        none = np.zeros(0, np.intp)
        return Echoes(depth[:, 0].copy(), power[:, 0].copy(), none, none)
    # most beams meet one surface: their sub-rays are summed without a look at pairs
    total, mean = power[:, 0].copy(), power[:, 0] * depth[:, 0]
    for s in range(1, depth.shape[1]):
        total += power[:, s]
        mean += power[:, s] * depth[:, s]
    # without an echo the mean is 0 already
    np.divide(mean, np.maximum(total, np.float32(1e-30)), out=mean)
    pixels = mixed_pixels(depth, primitive, pulse_length) if mixed is None else mixed
    of_rays = rays_of(pixels, depth.shape)
    range_, power_, brightest = _separate(depth.ravel()[of_rays], power.ravel()[of_rays], pulse_length, last)
    mean.reshape(-1)[pixels], total.reshape(-1)[pixels] = range_, power_
    return Echoes(mean, total, pixels, of_rays[brightest, np.arange(len(pixels))])


def rays_of(pixels: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Flat indices [S, N] into images [H, S, W] of the sub-rays of pixels [N] of images [H, W]."""
    _, rays, columns = shape
    row, column = np.divmod(pixels, columns)
    indices: np.ndarray = row * (rays * columns) + column + columns * np.arange(rays)[:, None]
    return indices


def _separate(
    depth: np.ndarray, power: np.ndarray, pulse_length: float, last: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Range, power and brightest sub-ray [N] of the echo that is reported of sub-rays [S, N]."""
    rays, pixels = depth.shape
    reach = np.float32(pulse_length)
    sums = np.zeros_like(power)
    for i in range(rays):
        sums[i] += power[i]
        for j in range(i):
            together = np.abs(depth[i] - depth[j]) <= reach
            sums[i] += together * power[j]
            sums[j] += together * power[i]
    # the furthest that is loud enough, or else, below 0, the strongest
    preferred = np.where(sums > 1.0, depth, -1.0 / (1.0 + sums)) if last else sums
    middle = depth[preferred.argmax(axis=0), np.arange(pixels)]
    echo = power * (np.abs(depth - middle) <= reach)
    total = echo.sum(axis=0)
    mean = np.divide((echo * depth).sum(axis=0), total, out=np.zeros_like(total), where=total > 0)
    return mean, total, echo.argmax(axis=0)


def winners(images: np.ndarray, echoes: Echoes) -> np.ndarray:
    """Of images [H, S, W] of sub-rays, what the one behind each echo saw: [H, W]."""
    seen = images[:, 0].copy()
    seen.reshape(-1)[echoes.mixed] = images.ravel()[echoes.winner]
    return seen
