"""Foliage and facades in pieces: halved where the cast of the layout disagrees with the points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lidardraft.drafting.cloud.clustering import FittedBox, fit_box, fit_crown
from lidardraft.drafting.cloud.rays import RayHits, Rays
from lidardraft.drafting.cloud.rules import BEAM_GAP, LONGEST_CROWN, ROUNDS, Detail
from lidardraft.scene.layout import Primitive
from lidardraft.semantics import CLASSES

_SAMPLE = 200  # points at most that tell which halves are better
_LEAST_SHOWN = 2  # returns that a useful piece shows


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Some points of a cloud, by their indices `members` [M], of one class and cluster, and the shape around them."""

    members: np.ndarray
    label: int
    shape: str
    cluster: int
    box: FittedBox

    @classmethod
    def from_points(cls, points: np.ndarray, members: np.ndarray, label: int, shape: str, cluster: int) -> Piece:
        """The piece whose shape, "box" or "ellipsoid", is fitted to `members` of points [N, 3].

        It is larger than its points by what beams are apart, so that pieces next to each other meet.
        """
        box = fit_box(points[members], outliers=0.0) if shape == "box" else fit_crown(points[members])
        gap = BEAM_GAP * float(np.linalg.norm(box.center))
        deep = gap if shape == "box" else 0.0  # a crown lies along the line of sight
        return cls(members, label, shape, cluster, replace(box, size=box.size + np.array([deep, gap, gap])))

    def tiles(self, points: np.ndarray) -> list[Piece]:
        """A long hedge in tiles of crowns' size, anything else as it is."""
        if self.shape == "box" or max(self.box.size[:2]) <= LONGEST_CROWN:
            return [self]
        axis = int(np.argmax(self.box.size[:2]))
        local = self.box.to_local(points[self.members])[:, axis]
        count = math.ceil(self.box.size[axis] / LONGEST_CROWN)
        tile = np.floor((local - local.min()) / (np.ptp(local) + 1e-9) * count)
        return [self.part(points, self.members[tile == number]) for number in np.unique(tile)]

    def part(self, points: np.ndarray, members: np.ndarray) -> Piece:
        """The piece around some of its points."""
        return Piece.from_points(points, members, self.label, self.shape, self.cluster)

    def primitive(self, id: str) -> Primitive:
        """The piece in a layout."""
        center, size = tuple(self.box.center.tolist()), tuple(self.box.size.tolist())
        label = CLASSES[self.label].name
        return Primitive(shape=self.shape, center=center, size=size, yaw=self.box.yaw, label=label, id=id)


def refined(pieces: Sequence[Piece], rays: Rays, others: Sequence[Primitive], detail: Detail) -> list[Piece]:
    """The pieces, halved until the cast of the layout agrees with the points, or there are as many as `detail` allows.

    `others` are the primitives that stay as they are. The pieces that are of no use go at the end, unless all of them
    are to stand on the ground, and what room that makes is used once more.
    """
    pieces = list(pieces)

    def cast() -> RayHits:
        return rays.cast([*(piece.primitive(str(index)) for index, piece in enumerate(pieces)), *others], rays.sample)

    whole: set[int] = set()  # first members of the pieces that halving does not mend
    for rounds in ROUNDS:
        for remaining in range(rounds, 0, -1):
            # the worst first, and some of the room is left for what is bad in later rounds
            room = -(-2 * (detail.most_shapes - len(others) - len(pieces)) // (remaining + 1))
            halves = _halved(pieces, rays, cast(), max(room, 0), detail, whole)
            if not halves:
                break
            pieces = [part for index, piece in enumerate(pieces) for part in halves.get(index, [piece])]
        if detail.grounded:
            break
        hits = cast()
        right = hits.per_piece(~hits.too_near & ~hits.too_far, len(pieces))
        useful = (right >= _LEAST_SHOWN) & (right > hits.per_piece(hits.too_near, len(pieces)))
        pieces = [piece for piece, kept in zip(pieces, useful.tolist(), strict=True) if kept]
    return pieces


def _halved(
    pieces: Sequence[Piece], rays: Rays, hits: RayHits, most: int, detail: Detail, whole: set[int]
) -> dict[int, list[Piece]]:
    """The halves of those pieces, `most` at most, by index, that are wrong for the most returns.

    A return that is shown too near counts against the piece in its way, one that is shown too far or not at all against
    the piece that it is a point of.
    """
    owner = np.full(len(rays.points), -1)
    for index, piece in enumerate(pieces):
        owner[piece.members] = index
    mine = owner[hits.chosen]
    own = hits.too_far & (mine >= 0)
    counts = hits.per_piece(hits.too_near, len(pieces)) + np.bincount(mine[own], minlength=len(pieces))
    wrong = counts * len(rays.points) / len(hits.chosen)
    halves: dict[int, list[Piece]] = {}
    for index in np.argsort(-wrong, kind="stable").tolist():
        if len(halves) >= most or wrong[index] < detail.worth:
            break
        first = int(pieces[index].members[0])
        if first in whole or pieces[index].box.size[:2].max() < detail.least_length:
            continue
        behind = hits.chosen[hits.too_near & (hits.primitive == index) & (mine != index)]
        parts = _halves(pieces[index], rays, behind, axes=2 if detail.grounded else 3)
        if len(parts) > 1:
            halves[index] = parts
        else:
            whole.add(first)
    return halves


def _halves(piece: Piece, rays: Rays, behind: np.ndarray, axes: int) -> list[Piece]:
    """The halves of a piece across that axis of its box where most returns become right, or the piece alone.

    The first `axes` of them are tried: two keep it as high as it is.
    `behind` are points of others that are seen past it, or should be.
    """
    local = piece.box.to_local(rays.points[piece.members])
    low, high = local.min(axis=0), local.max(axis=0)
    own, other = _sample(piece.members), _sample(behind)
    seen = np.concatenate([own, other])
    best, least = [piece], np.inf
    for axis in np.argsort((low - high)[:axes], kind="stable"):
        far = local[:, axis] > (low[axis] + high[axis]) / 2
        if far.all() or not far.any():
            continue
        parts = [piece.part(rays.points, piece.members[side]) for side in (far, ~far)]
        hits = rays.cast([part.primitive(str(side)) for side, part in enumerate(parts)], seen)
        wrong = np.mean((hits.too_near | hits.too_far)[: len(own)]) * len(piece.members)
        if len(other):
            wrong += np.mean(hits.too_near[len(own) :]) * len(behind)
        if wrong < least:
            best, least = parts, wrong
    return best


def _sample(indices: np.ndarray) -> np.ndarray:
    return indices[:: max(1, -(-len(indices) // _SAMPLE))]
