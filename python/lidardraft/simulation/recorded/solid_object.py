"""An object to put into a recorded scan: built in detail and compiled once, in its own frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LayoutError, one_of
from lidardraft.json_fields import are_numbers
from lidardraft.objects.coarse_shapes import CoarseShape, extents, resized, standing
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.objects.placed_object import Vector
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.pose import upright
from lidardraft.scene.raycast import Hits, Raycaster
from lidardraft.scene.surfaces import Surfaces
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.detail.coarse_object import generator_of
from lidardraft.simulation.detail.detail import detail

_RIDDEN = {"cyclist": "bicycle", "motorcyclist": "motorcycle"}
WORDS = (*(name for name, kind in SENTENCE_KINDS.items() if kind.sizes), *_RIDDEN)
_WORD_OF_CLASS = {"rider": "cyclist", "train": "tram"}


def sampled_parts(word: str, seed: int, name: str) -> list[CoarseShape]:
    """The shapes of one of `WORDS`, in a sampled size; raises `LayoutError` for another word."""
    if word not in WORDS:
        raise LayoutError(f"{word!r} is no object that can be inserted; it must be {one_of(WORDS, word)}")
    kind = SENTENCE_KINDS[_RIDDEN.get(word, word)]
    return kind.sample_parts(generator_of(seed, name), parked=word not in _RIDDEN)


@dataclass(frozen=True, eq=False)
class SolidObject:
    """An object in its own frame: x ahead, z up, the origin on the ground under the middle of its box.

    `label` is the class of its box, `size` the box's extents [m].
    """

    label: str
    size: Vector
    caster: Raycaster
    surfaces: Surfaces

    @classmethod
    def of_kind(cls, word: str, *, size: Vector | None = None, name: str = "", seed: int = 0) -> SolidObject:
        """One of `WORDS`, with sampled extents of its kind if no `size` is given; `seed` and `name` decide the rest.

        Raises `LayoutError` for another word."""
        parts, kind = sampled_parts(word, seed, name), SENTENCE_KINDS[_RIDDEN.get(word, word)]
        if size is not None:
            if not are_numbers(size, 3) or min(size) <= 0:
                raise LayoutError(f"{name or word}: size is {size!r:.80}; it must be three lengths above 0 m")
            x, y, z = (wanted / had for wanted, had in zip(size, extents(parts), strict=True))
            parts = resized(parts, (x, y, z))
        return cls._of_parts(parts, "rider" if word in _RIDDEN else kind.label, name or word, seed)

    @classmethod
    def of_class(cls, label: str, size: Vector, *, name: str = "", seed: int = 0) -> SolidObject:
        """The object that a box of that class and size represents."""
        word = _WORD_OF_CLASS.get(label, label)
        if word in WORDS:
            return cls.of_kind(word, size=size, name=name, seed=seed)
        return cls._of_parts([standing("box", size, label)], label, name or label, seed)

    @classmethod
    def _of_parts(cls, parts: list[CoarseShape], label: str, name: str, seed: int) -> SolidObject:
        primitives = tuple(
            Primitive(
                shape=part.shape,
                center=part.center,
                size=part.size,
                label=part.label,
                id=f"{name}.{part.name}" if part.name else name,
                instance=number if BY_NAME[part.label].is_thing else 0,
            )
            for number, part in enumerate(parts, start=1)
        )
        layout = detail(Layout(primitives), seed=seed)
        return cls(label, extents(parts), Raycaster(layout, by_id=True), Surfaces.from_layout(layout, by_id=True))

    def cast(self, place: Vector, yaw: float, directions: np.ndarray, furthest: float, seed: int) -> Hits:
        """The hits of rays from the origin in `directions` [R, 3] on the object at `place` [m] with `yaw` [rad], up to
        `furthest` [m]; in the frame of the object."""
        pose = upright(place, yaw)
        return self.caster.cast(-pose[:3, 3] @ pose[:3, :3], directions @ pose[:3, :3], max_range=furthest, seed=seed)
