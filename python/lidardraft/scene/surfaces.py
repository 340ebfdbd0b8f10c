"""The surfaces of a layout as a table: the response of each primitive at each incidence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from zlib import crc32

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.materials import (
    CLASS_MATERIALS,
    MATERIALS,
    fresnel,
    leaf_response,
    response,
)
from lidardraft.semantics import BY_NAME

# The distance behind a pane (curtains, seats) is the same for all of it: its median [m] and the spread of its
# logarithm, estimates.
_BEHIND, _BEHIND_SPREAD = 0.25, 0.6
_TINT_SPREAD = 0.4  # of the logarithm of a pane's transmission, an estimate: coatings, tints, dirt
_BINS = 128  # of incidence, as in the core's table; 0.9 degrees each
_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
_INDEX = {material.name: i for i, material in enumerate(MATERIALS)}
# A film of water fills the pores of porous ground, which then returns about half as much (Lekner and Dorf, Applied
# Optics 27, 1988). The light that the film mirrors never returns to a sensor that does not face it.
_WET_SHARE = 0.5
_WETTED = frozenset({"asphalt", "concrete", "paving", "gravel", "soil", "road-paint", "stone"})


@dataclass(frozen=True, slots=True, eq=False)
class Surfaces:
    """`table` f32 [P + 1, 128]: the response of each primitive in bins of the root of 1 - cosine of incidence, which is
    nearly linear in the angle; 1 is a white surface that faces the sensor. Row 0 is that of no return.

    `transmission`, `grain`, `texture`, `rms_height` and `unevenness`, f32 [P + 1], are those of the primitives'
    materials, `behind` is the distance [m] from glass to the next surface behind it. Make it once for a layout that is
    scanned often.
    """

    table: np.ndarray
    transmission: np.ndarray
    behind: np.ndarray
    grain: np.ndarray
    texture: np.ndarray
    rms_height: np.ndarray
    unevenness: np.ndarray

    @classmethod
    def from_layout(
        cls, layout: Layout, *, wetness: float = 0.0, variation: bool = True, by_id: bool = False
    ) -> Surfaces:
        """The surfaces of `layout`, its ground wet by `wetness`, 0 to 1.

        Without `variation` the primitives of one material are all alike. Variation follows from the place of a
        primitive or, with `by_id`, from its id: then a moved one keeps its brightness. Raises `SensorError` if
        `wetness` is not 0 to 1.
        """
        primitives = layout.primitives
        names = [p.material or CLASS_MATERIALS[BY_NAME[p.label].id].name for p in primitives]
        index = np.array([_INDEX[name] for name in names], dtype=np.intp)
        media = np.array([p.extinction is not None for p in primitives], dtype=bool)
        keys = _keys_from_ids(primitives) if by_id else _keys_from_places(primitives)
        return cls._made_of(index, media, keys if variation else None, wetness)

    @classmethod
    def joined(cls, parts: Sequence[Surfaces]) -> Surfaces:
        """The surfaces of several sets, in order."""
        first = [cls.from_layout(Layout()), *parts]  # the row of no return is that of the first
        columns = [[getattr(part, field.name) for part in first] for field in fields(cls)]
        return cls(*(np.concatenate([one[0], *(more[1:] for more in one[1:])]) for one in columns))

    def some(self, indices: np.ndarray) -> Surfaces:
        """The surfaces of the primitives with these indices."""
        kept = np.concatenate([[0], indices.astype(np.intp) + 1])
        return Surfaces(*(getattr(self, field.name)[kept] for field in fields(self)))

    @classmethod
    def from_materials(cls, materials: np.ndarray, keys: np.ndarray, *, wetness: float = 0.0) -> Surfaces:
        """Surfaces of `materials` [P], indices of `MATERIALS`; foliage is a medium, whose leaves face every way.

        `keys` u64 [P] decide how each differs from others of its material; 0 gives the typical one. Raises
        `SensorError` if `wetness` is not 0 to 1.
        """
        return cls._made_of(materials, materials == _INDEX["foliage"], keys, wetness)

    @classmethod
    def _made_of(cls, index: np.ndarray, media: np.ndarray, keys: np.ndarray | None, wetness: float) -> Surfaces:
        if not 0.0 <= wetness <= 1.0:
            raise SensorError(f"wetness is {wetness}; it must be 0 to 1")
        table = np.zeros((len(index) + 1, _BINS), np.float32)
        np.take(_responses(wetness), index, axis=0, out=table[1:])
        # leaves face every way: the incidence on the hull of a medium means nothing
        table[1:][media] = np.array([leaf_response(m) for m in MATERIALS])[index[media], None]
        if keys is not None:
            spread = np.array([m.variation for m in MATERIALS])[index]
            paint = index == _INDEX["road-paint"]
            alike = np.where(paint, keys[paint][:1].sum(), keys)  # the paint of a street is of one age
            scatter = np.where(alike == 0, 0.0, _nearly_normal(alike))
            table[1:] *= np.exp(spread * scatter).astype(np.float32)[:, None]
        columns = np.zeros((6, len(index) + 1), np.float32)
        constants = [(m.transmission, _BEHIND, m.grain, m.texture, m.rms_height, m.unevenness) for m in MATERIALS]
        columns[:, 1:] = np.array(constants)[index].T
        if keys is not None:
            for row, spread, factor in ((0, _TINT_SPREAD, _FACTORS[2]), (1, _BEHIND_SPREAD, _FACTORS[1])):
                columns[row, 1:] *= np.exp(spread * _nearly_normal(keys * factor))
            columns[0] = np.minimum(columns[0], 1.0)
        columns[4:, 1:][:, media] = 0.0
        return cls(table, *columns)


def _responses(wetness: float) -> np.ndarray:
    """The response of each material in each bin of incidence, f32 [M, bins]."""
    cosine = 1.0 - ((np.arange(_BINS) + 0.5) / _BINS) ** 2
    film = 1.0 - wetness * (1.0 - _WET_SHARE * (1.0 - fresnel(cosine)) ** 2)
    rows = [response(m, cosine) * (film if m.name in _WETTED else 1.0) for m in MATERIALS]
    return np.array(rows, np.float32)


def _keys_from_places(primitives: tuple[Primitive, ...]) -> np.ndarray:
    places = np.array([p.center for p in primitives]).reshape(-1, 3).view(np.uint64)
    keys: np.ndarray = (places * _FACTORS).sum(axis=1)
    return keys


def _keys_from_ids(primitives: tuple[Primitive, ...]) -> np.ndarray:
    return np.array([crc32(p.id.encode()) for p in primitives], np.uint64) * _FACTORS[0]


def _nearly_normal(keys: np.ndarray) -> np.ndarray:
    """A nearly normal number of variance 1 for each key u64 [P]: f64 [P]."""
    mixed = keys ^ keys >> np.uint64(31)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    mixed ^= mixed >> np.uint64(29)
    quarters = mixed.view(np.uint16).reshape(-1, 4) / 65535.0
    # four uniform numbers have the variance 4 / 12
    scatter: np.ndarray = (quarters.sum(axis=1) - 2.0) * np.sqrt(3.0)
    return scatter
