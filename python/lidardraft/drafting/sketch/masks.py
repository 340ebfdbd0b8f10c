"""A piece of a sketch, as a mask of pixels, is a blob, or strokes that touch and cross: centre lines with widths.

Places on centre lines are (down, right) in pixels.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from lidardraft.drafting.sketch.shapes import Blob, SketchFrame, Stroke, resampled, smooth, without_bumps
from lidardraft.errors import FormatError
from lidardraft.semantics import GROUND

STROKE_CLASSES = ("road", "sidewalk", "wall", "fence", "vegetation")  # drawn as strokes, or as blobs
_SLENDER = 2.5  # times as long as wide: the least of a stroke
_NARROW = 0.5  # of the width of an area: a narrower strip is an arm that leads to it
_ARM = 0.4  # of the square of that: a smaller piece is a corner
_NEARLY_SQUARE = 1.3  # times as long as wide: below, moments give no reliable direction
_THICK = 5.0  # pixels from the middle of a stroke to its edge: thicker ones are thinned in a coarser image
_SPUR = 1.7  # times the half width: shorter ends come from bumps of the outline, or from corners of an end
_BEND = math.radians(40)  # the limit for the turn of a line through a junction
_OVERLAP = 0.75  # of the half width of a stroke: strokes that meet it end here, without a gap
_BUMP = 3.0  # times the half width: bumps and bites of the outline up to this length are not bends
_RAY_STEP = 0.5  # pixels: rays to both edges end half a step beyond them on average
_MOST_PIXELS = 60_000  # of all middle lines of a mask
_MOST_BRANCHES = 2000  # of a mask, between junctions of strokes
_EIGHT = np.ones((3, 3), dtype=bool)
# Around a pixel, clockwise from above: down and right.
_AROUND = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))


Joined = dict[tuple[int, int], tuple[int, int]]  # from an end (branch, 0 or 1) to the one that continues it


def shapes_of_mask(
    mask: np.ndarray, frame: SketchFrame, label: str, names: tuple[str, ...], where: str
) -> Iterator[Blob | Stroke]:
    """The shapes in a mask bool [H, W], whose pixel 0, 0 is at 0, 0 of the frame. Outlines of objects are filled."""
    if label not in STROKE_CLASSES:
        mask = ndimage.binary_fill_holes(mask)
    slender = label in STROKE_CLASSES and _is_slender(mask)
    if label in GROUND and not slender:
        mask, arms = _without_arms(mask)
        for arm in arms:
            yield from shapes_of_mask(arm, frame, label, names, where)
    lines = list(centre_lines(mask)) if slender else []
    grain = frame.metres_per_unit
    for line in lines:
        points = frame.to_layout(line.points[:, ::-1])
        yield Stroke(label, names, where, points, line.width * grain, line.closed, grain)
    if not lines:
        points = frame.to_layout(np.argwhere(mask)[:, ::-1].astype(np.float64))
        yield Blob(label, names, where, *_rectangle(points, grain))


def _is_slender(mask: np.ndarray) -> bool:
    inner = float(ndimage.distance_transform_edt(np.pad(mask, 1)).max())
    return bool(np.count_nonzero(mask) >= _SLENDER * (2 * inner) ** 2)


def _without_arms(mask: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """An area bool [H, W] without the narrow strips that lead to it, as to a car park, and these strips."""
    padded = np.pad(mask, 1)
    depth = ndimage.distance_transform_edt(padded)
    reach = _NARROW * float(depth.max())
    core = (ndimage.distance_transform_edt(depth <= reach) < reach)[1:-1, 1:-1] & mask
    pieces, count = ndimage.label(mask & ~core, np.ones((3, 3)))
    sizes = np.bincount(pieces.ravel(), minlength=count + 1)
    arms = [pieces == number for number in range(1, count + 1) if sizes[number] > _ARM * reach**2]
    return (mask & ~np.any(arms, axis=0) if arms else mask), arms


def _rectangle(points: np.ndarray, grain: float) -> tuple[np.ndarray, float, float, float]:
    """Centre [2], length, width and yaw of the rectangle with the same moments as pixels at `points` [N, 2].

    A rectangle of length L has the variance L^2 / 12 along it, which wobbles of an outline hardly change.
    """
    center = points.mean(axis=0)
    off = points - center
    # a pixel is a square, not a point: its own variance is a twelfth
    covariance = off.T @ off / len(off) + np.eye(2) * grain**2 / 12
    values, vectors = np.linalg.eigh(covariance)
    yaw = math.atan2(vectors[1, 1], vectors[0, 1])
    if values[1] < _NEARLY_SQUARE**2 * values[0] and len(points) > 3:
        yaw = _tightest_yaw(off)
    axes = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
    extents = np.sqrt(12.0 * np.diag(axes @ covariance @ axes.T))
    if extents[1] > extents[0]:
        extents, yaw = extents[::-1], yaw + math.pi / 2
    return center, float(extents[0]), float(extents[1]), yaw


def _tightest_yaw(off: np.ndarray) -> float:
    """The heading of the smallest rectangle around pixels, given row by row, to a degree."""
    rows = np.flatnonzero(np.diff(off[:, 0]))  # the starts of the next rows: the ends of a row are its outermost pixels
    corners = off[[0, *rows, *rows + 1, -1]]
    headings = np.deg2rad(np.arange(90.0))
    along = corners @ np.stack([np.cos(headings), np.sin(headings)])
    across = corners @ np.stack([-np.sin(headings), np.cos(headings)])
    return float(headings[np.argmin(np.ptp(along, axis=0) * np.ptp(across, axis=0))])


@dataclass(frozen=True, slots=True, eq=False)
class CentreLine:
    """Points f64 [N, 2] of the middle of a stroke, and its width [pixels]; a closed one ends at its start."""

    points: np.ndarray
    width: float
    closed: bool


@dataclass(slots=True, eq=False)
class _Branch:
    """Points from one node to another; a node is None at a free end of the stroke."""

    points: np.ndarray
    nodes: list[int | None]

    @property
    def length(self) -> float:
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


@dataclass(slots=True, eq=False)
class _Graph:
    """Branches by number, and the middle [2] and half width of each node [pixels]."""

    branches: dict[int, _Branch]
    middles: dict[int, np.ndarray]
    halves: dict[int, float]

    def met_at(self, number: int, end: int) -> int | None:
        """The node at an end of a branch, if other branches meet it there."""
        node = self.branches[number].nodes[end]
        return node if node is not None and len(self.ends_at(node)) > 1 else None

    def ends_at(self, node: int) -> list[tuple[int, int]]:
        return [(k, end) for k, branch in self.branches.items() for end in (0, 1) if branch.nodes[end] == node]


def centre_lines(mask: np.ndarray) -> Iterator[CentreLine]:
    """The strokes of a mask bool [H, W] of one piece. At a junction, the stroke that goes straight on is whole, and the
    others end at its edge. Raises `FormatError` if there are too many."""
    depth = ndimage.distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
    step = max(1, int(depth.max() / _THICK))
    coarse = mask
    if step > 1:
        share = ndimage.uniform_filter(mask.astype(np.float32), step, mode="constant")
        coarse = share[step // 2 :: step, step // 2 :: step] > 0.5
        depth = ndimage.maximum_filter(depth, step + 1)  # a coarse line is up to half a step off the middle
    graph = _graph(thinned(coarse), step, step // 2, depth)
    _prune(graph, step)
    _join_near_nodes(graph)
    for points, closed in _through_lines(graph, depth):
        yield _recentred(mask, points, closed, float(np.median(_at(depth, points))))


def _recentred(mask: np.ndarray, points: np.ndarray, closed: bool, half: float) -> CentreLine:
    """The line in the middle between both edges of the mask, which thinning finds only to within a step.

    Bumps and bites, as of cars at the edge of a road, are shorter than the window of the median.
    """
    raw, spacing = resampled(points, max(1.0, half / 3))
    line = smooth(raw, min(3.0, len(raw) / 6), closed)
    ahead = np.gradient(line, axis=0)
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)
    aside = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    away = np.arange(0.0, 2.0 * half + 2.0, _RAY_STEP)
    reaches, between = [], np.ones(len(line), dtype=bool)
    for side in (-1.0, 1.0):
        rays = line[:, None] + side * away[:, None] * aside[:, None]
        inside = _at(np.pad(mask, 1), rays.reshape(-1, 2) + 1).reshape(rays.shape[:2])
        reaches.append(away[np.argmin(inside, axis=1)])
        between &= ~inside.all(axis=1)  # and not into another stroke at a junction
    if not between.any():
        return CentreLine(line, 2.0 * half, closed)
    known, places = np.flatnonzero(between), np.arange(len(line))
    left, right = (np.interp(places, known, reach[known]) for reach in reaches)
    window = 2 * round(_BUMP * half / spacing) + 1
    middle = without_bumps(line + ((right - left) / 2)[:, None] * aside, window, closed)
    return CentreLine(middle, float(np.median(left + right)) - _RAY_STEP, closed)


def _at(depth: np.ndarray, points: np.ndarray) -> np.ndarray:
    down, right = np.clip(np.rint(points).astype(np.int64), 0, np.array(depth.shape) - 1).T
    values: np.ndarray = depth[down, right]
    return values


def _graph(thin: np.ndarray, step: int, offset: int, depth: np.ndarray) -> _Graph:
    if (count := np.count_nonzero(thin)) > _MOST_PIXELS:
        raise FormatError(f"the strokes of one colour are {count} pixels long; up to {_MOST_PIXELS} are read")
    meeting = branch_points(thin)
    node_of, nodes = ndimage.label(meeting, _EIGHT)
    paths, count = ndimage.label(thin & ~meeting, _EIGHT)
    if max(nodes, count) > _MOST_BRANCHES:
        raise FormatError(
            f"the strokes of one colour meet {nodes} times, in {count} pieces; up to {_MOST_BRANCHES} are read"
        )
    middles = ndimage.center_of_mass(meeting, node_of, range(1, nodes + 1))
    graph = _Graph({}, {k: np.array(middle) * step + offset for k, middle in enumerate(middles, start=1)}, {})
    graph.halves = {k: float(_at(depth, middle[None])[0]) for k, middle in graph.middles.items()}
    near_node = ndimage.maximum_filter(node_of, 3)
    for number, box in enumerate(ndimage.find_objects(paths), start=1):
        corner = np.array([part.start for part in box])
        path = _walked(np.argwhere(paths[box] == number)) + corner
        found: list[int | None] = [int(near_node[tuple(path[end])]) or None for end in (0, -1)]
        if len(path) == 1:  # between two nodes
            down, right = path[0]
            beside = np.unique(node_of[max(down - 1, 0) : down + 2, max(right - 1, 0) : right + 2])
            found = [int(node) for node in beside if node]
            found = [*found, None, None][:2]
        points = path * float(step) + offset
        ends = [[graph.middles[node]] if node else [] for node in found]
        graph.branches[number] = _Branch(np.array([*ends[0], *points, *ends[1]]), found)
    return graph


def _walked(pixels: np.ndarray) -> np.ndarray:
    """The pixels [N, 2] of a path from one end of it to the other."""
    left = set(map(tuple, pixels.tolist()))
    nearest = sorted(_AROUND, key=lambda off: abs(off[0]) + abs(off[1]))

    def neighbours(at: tuple[int, ...]) -> list[tuple[int, ...]]:
        return [near for off in nearest if (near := (at[0] + off[0], at[1] + off[1])) in left]

    at = next((pixel for pixel in sorted(left) if len(neighbours(pixel)) == 1), min(left))
    path = [at]
    left.remove(at)
    while near := neighbours(at):
        at = near[0]
        path.append(at)
        left.remove(at)
    return np.array(path)


def _prune(graph: _Graph, step: int) -> None:
    """Remove the ends that are not strokes; the line that they branch from stays."""
    while True:
        spurs = []
        for number, branch in graph.branches.items():
            node = graph.met_at(number, 0) or graph.met_at(number, 1)
            if node and None in branch.nodes and branch.length < _SPUR * graph.halves[node] + 2 * step:
                spurs.append((branch.length, number))
        if not spurs:
            return
        del graph.branches[min(spurs)[1]]


def _join_near_nodes(graph: _Graph) -> None:
    """Merge two nodes of one crossing, a short branch apart."""
    for number, branch in list(graph.branches.items()):
        first, second = branch.nodes
        if first is None or second is None or branch.length > max(graph.halves[first], graph.halves[second]):
            continue
        del graph.branches[number]
        if first == second:
            continue
        graph.middles[first] = (graph.middles[first] + graph.middles[second]) / 2
        graph.halves[first] = max(graph.halves[first], graph.halves[second])
        for other, end in graph.ends_at(second):
            graph.branches[other].nodes[end] = first


def _through_lines(graph: _Graph, depth: np.ndarray) -> Iterator[tuple[np.ndarray, bool]]:
    """The branches, joined if they go on through a node, and whether they are closed."""
    joined: Joined = {}
    for node in graph.middles:
        if pair := _straightest(graph, node):
            joined |= {pair[0]: pair[1], pair[1]: pair[0]}
    left = set(graph.branches)
    begins = [(k, end) for k in sorted(left) for end in (0, 1) if (k, end) not in joined]
    for begin in [*begins, *((k, 0) for k in sorted(left))]:
        if begin[0] not in left:
            continue
        pieces, at = [], begin
        while True:
            number, end = at
            left.discard(number)
            pieces.append(_trimmed(graph, number, joined, depth)[:: 1 if end == 0 else -1])
            onward = joined.get((number, 1 - end))
            if onward is None or onward == begin or onward[0] not in left:
                break
            at = onward
        points = np.concatenate(pieces)
        closed = onward == begin
        if len(pieces) == 1 and graph.branches[number].nodes == [None, None] and len(points) > 8:
            closed |= bool(np.linalg.norm(points[0] - points[-1]) < 2.0 * _at(depth, points[:1])[0])
        if len(points) > 1:
            whole = np.concatenate([points, points[:1]]) if closed else _lengthened(points, begin, at, graph, depth)
            yield whole, closed


def _straightest(graph: _Graph, node: int) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """The two ends at a node that are one stroke: those of the longest pair that hardly turns."""
    ends = graph.ends_at(node)
    ahead = [_direction(graph, number, end, graph.halves[node]) for number, end in ends]
    pairs = [(i, j) for j in range(len(ends)) for i in range(j) if ends[i][0] != ends[j][0] or len(ends) == 2]
    if len(ends) != 2:
        pairs = [(i, j) for i, j in pairs if float(ahead[i] @ ahead[j]) < -math.cos(_BEND)]
    if not pairs:
        return None
    i, j = max(pairs, key=lambda pair: sum(graph.branches[ends[k][0]].length for k in pair))
    return ends[i], ends[j]


def _direction(graph: _Graph, number: int, end: int, half: float) -> np.ndarray:
    """The unit vector along a branch away from its end, measured beyond the part that the node distorts."""
    points = graph.branches[number].points[:: 1 if end == 0 else -1]
    near, far = (_beyond(points, points[0], reach) for reach in (half, 4 * half))
    off = far - (near if np.any(far != near) else points[0])
    length = float(np.linalg.norm(off))
    return off / length if length else np.zeros(2)


def _beyond(points: np.ndarray, place: np.ndarray, reach: float) -> np.ndarray:
    """The first of points [N, 2] at least `reach` from a place [2], or the furthest one."""
    away = np.linalg.norm(points - place, axis=1)
    first: np.ndarray = points[np.argmax(away >= min(reach, away.max()))]
    return first


def _trimmed(graph: _Graph, number: int, joined: Joined, depth: np.ndarray) -> np.ndarray:
    """The points of a branch without those at its nodes, which other strokes distort; it ends at the edge of a stroke
    that goes on there."""
    branch = graph.branches[number]
    keep = np.ones(len(branch.points), dtype=bool)
    met = [graph.met_at(number, end) for end in (0, 1)]
    for each in filter(None, met):
        keep &= np.linalg.norm(branch.points - graph.middles[each], axis=1) > graph.halves[each]
    points = branch.points[keep]
    for end, node in enumerate(met):
        if node is None or (number, end) in joined or not len(points):
            continue
        through = [other for other in joined if graph.branches[other[0]].nodes[other[1]] == node]
        edge = _edge_of(graph, node, through, points[-end], depth) if through else graph.middles[node]
        points = np.concatenate([points, edge[None]] if end else [edge[None], points])
    return points


def _edge_of(
    graph: _Graph, node: int, through: list[tuple[int, int]], beside: np.ndarray, depth: np.ndarray
) -> np.ndarray:
    """The point at which a line from `beside` [2] meets the stroke that goes on through a node, within its edge.

    The stroke is taken between its parts on both sides of the node, whose own middle is pulled towards the strokes that
    meet there.
    """
    half = float(np.mean([np.median(_at(depth, graph.branches[number].points)) for number, _ in through]))
    lines = [graph.branches[number].points[:: -1 if end else 1] for number, end in through]
    sides = [_beyond(line, graph.middles[node], 2.0 * half) for line in lines]
    ahead = sides[1] - sides[0]
    share = float((graph.middles[node] - sides[0]) @ ahead) / max(float(ahead @ ahead), 1e-9)
    middle = sides[0] + share * ahead
    away = float(np.linalg.norm(beside - middle))
    edge: np.ndarray = middle + (beside - middle) * min(_OVERLAP * half / max(away, 1e-9), 1.0)
    return edge


def _lengthened(
    points: np.ndarray, begin: tuple[int, int], last: tuple[int, int], graph: _Graph, depth: np.ndarray
) -> np.ndarray:
    """The line with its free ends extended to the edge of the mask, from which thinning pulls them in."""
    ends = []
    for (number, end), row in ((begin, points), ((last[0], 1 - last[1]), points[::-1])):
        half = float(_at(depth, row[:1])[0])
        off = row[0] - _beyond(row, row[0], 3 * half + 2)
        length = float(np.linalg.norm(off))
        free = graph.met_at(number, end) is None and length > 0
        ends.append((row[0] + off / length * (half - 0.5))[None] if free else row[:0])
    return np.concatenate([ends[0], points, ends[1]])


def thinned(mask: np.ndarray) -> np.ndarray:
    """The middle lines bool [H, W], one pixel wide, of a mask bool [H, W] of thick strokes.

    Guo and Hall, "Parallel thinning with two-subiteration algorithms", Communications of the ACM 1989.
    """
    padded = np.pad(mask, 1)
    thin, near = padded[1:-1, 1:-1], around(padded)
    before = -1
    while before != (before := int(np.count_nonzero(thin))):
        for turned in (0, 4):  # from one side, then from the other
            n, ne, e, se, s, sw, w, nw = near[turned:] + near[:turned]
            pieces = how_many(~a & (b | c) for a, b, c in ((n, ne, e), (e, se, s), (s, sw, w), (w, nw, n)))
            pairs = np.minimum(how_many([nw | n, ne | e, se | s, sw | w]), how_many([n | ne, e | se, s | sw, w | nw]))
            thin &= (pieces != 1) | (pairs < 2) | (pairs > 3) | ((s | sw | ~nw) & w)
    return thin


def branch_points(thin: np.ndarray) -> np.ndarray:
    """The junctions of lines one pixel wide, bool [H, W]."""
    meeting: np.ndarray = thin & (how_many(around(np.pad(thin, 1))) >= 3)
    return meeting


def around(padded: np.ndarray) -> list[np.ndarray]:
    """The neighbours of each pixel [H, W], clockwise from above: views of the image with an edge [H + 2, W + 2]."""
    height, width = padded.shape[0] - 2, padded.shape[1] - 2
    return [padded[1 + down :, 1 + right :][:height, :width] for down, right in _AROUND]


def how_many(masks: Iterable[np.ndarray]) -> np.ndarray:
    """The number of masks [H, W] that are set at each pixel, u8 [H, W]."""
    count: np.ndarray = sum(mask.view(np.uint8) for mask in masks)  # type: ignore[assignment]
    return count
