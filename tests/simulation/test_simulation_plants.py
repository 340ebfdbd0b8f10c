"""Plants: trees, hedges, and foliage as media."""

import numpy as np
import pytest
from coarse_boxes import box, detailed, materials

from lidardraft.scene.mesh import primitive_mesh


def test_a_trunk_and_a_crown_become_one_tree() -> None:
    trunk = box("trunk", (0.5, 0.5, 3.0), id="tree_1.trunk", shape="cylinder")
    crown = box("vegetation", (4.0, 4.0, 5.0), at=(15.0, 3.0, 2.0), id="tree_1.crown", shape="ellipsoid")
    for seed in range(30):
        parts = detailed(trunk, crown, seed=seed)
        stem = parts[0]
        assert (stem.shape, stem.size[:2], stem.center[:2]) == ("cylinder", (0.5, 0.5), (15.0, 3.0))
        leaves = [p for p in parts if p.label == "vegetation"]
        assert all(p.extinction is not None for p in leaves)
        vertices = np.concatenate([primitive_mesh(p).vertices for p in leaves])
        assert vertices[:, 2].min() >= 2.0 - 1e-6
        assert vertices[:, 2].max() <= 7.0 + 1e-6
        assert max(p.extinction for p in leaves) > 0.2, "it is in leaf"


def test_a_trunk_and_a_crown_of_two_names_become_one_tree() -> None:
    trunk = box("trunk", (0.5, 0.5, 3.0), id="stem", shape="cylinder")
    crown = box("vegetation", (4.0, 4.0, 5.0), at=(15.0, 3.0, 2.0), id="leaves", shape="ellipsoid")
    parts = detailed(trunk, crown)
    boughs = [p for p in parts if p.label == "trunk"]
    assert len(boughs) > 1
    assert {p.id.split(".")[0] for p in boughs} == {"stem"}
    assert {p.id.split(".")[0] for p in parts if p.label == "vegetation"} == {"leaves"}
    (alone,) = [p for p in detailed(trunk, crown, source="point cloud") if p.label == "trunk"]
    assert alone.size == trunk.size


def test_a_bush_beside_a_trunk_is_not_its_crown() -> None:
    trunk = box("trunk", (0.5, 0.5, 3.0), id="stem", shape="cylinder")
    for at in ((16.5, 3.0, 2.0), (15.0, 3.0, 0.0), (15.0, 3.0, 4.0)):  # aside, on the ground, high over it
        bush = box("vegetation", (4.0, 4.0, 2.0), at=at, id="bush", shape="ellipsoid")
        (stem,) = [p for p in detailed(trunk, bush) if p.label == "trunk"]
        assert stem.size == trunk.size


def test_pieces_of_a_crown_become_a_medium_each() -> None:
    pieces = [
        box("vegetation", (1.0, 1.2, 0.9), at=(15, k, 2), id=f"vegetation_{k}", shape="ellipsoid") for k in range(5)
    ]
    made = detailed(*pieces, source="point cloud")
    assert [(p.id, p.shape, p.center, p.size) for p in made] == [(p.id, p.shape, p.center, p.size) for p in pieces]
    assert all(p.extinction for p in made)


def test_pieces_of_a_clustering_are_as_dense_whatever_their_size() -> None:
    sizes = ((0.6, 0.5, 0.4), (1.5, 1.6, 1.69), (2.0, 2.5, 1.8))
    pieces = [
        box("vegetation", s, at=(15, 4 * k, 2), id=f"vegetation_{k}", shape="ellipsoid") for k, s in enumerate(sizes)
    ]
    made = detailed(*pieces, source="point cloud")
    assert len(made) == 3
    paths = [p.extinction * min(p.size) for p in made if p.extinction is not None]
    assert paths == pytest.approx([paths[0]] * 3)
    assert paths[0] > 4.0


@pytest.mark.parametrize("shape", ["ellipsoid", "cylinder", "box"])
@pytest.mark.parametrize("size", [(0.02, 0.02, 0.02), (2.0, 2.0, 1.5), (20.0, 20.0, 0.3), (1.0, 8.0, 1.5)])
def test_foliage_of_any_shape_is_a_medium(shape: str, size: tuple[float, float, float]) -> None:
    parts = detailed(box("vegetation", size, shape=shape))
    assert all(p.extinction for p in parts)
    assert materials(parts) == {"foliage"}


def test_the_trunks_that_a_clustering_finds_stay() -> None:
    (part,) = detailed(box("trunk", (0.3, 0.3, 2.0), shape="cylinder"), source="point cloud")
    assert (part.size, part.material) == ((0.3, 0.3, 2.0), "bark")
