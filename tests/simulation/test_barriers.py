"""Walls and fences."""

from coarse_boxes import box, detailed, materials


def test_segments_of_one_fence_are_alike() -> None:
    for seed in range(10):
        segments = [box("fence", (4.0, 0.1, 1.5), at=(15 + 4 * k, 3, 0), id=f"fence_1.{k + 1}") for k in range(4)]
        made = detailed(*segments, seed=seed)
        near = [{(p.shape, p.material) for p in made if abs(p.center[0] - 15 - 4 * k) < 2} for k in range(4)]
        assert near[0] == near[1] == near[2] == near[3]


def test_fences_are_seen_through_and_some_are_of_mesh() -> None:
    made = [detailed(box("fence", (12.0, 0.1, 1.5), id=f"fence_{k}")) for k in range(60)]
    meshes = sum(any(p.extinction for p in parts) for parts in made)
    assert 3 < meshes < 25
    assert {p.label for parts in made for p in parts} == {"fence"}
    assert {"wood", "metal"} <= {p.material for parts in made for p in parts}


def test_a_fence_along_the_width_of_its_box_stands_there() -> None:
    parts = detailed(box("fence", (0.1, 12.0, 1.5)))
    assert max(p.size[0] for p in parts) > 11.0
    assert len({p.material for p in parts}) == 1


def test_walls_have_plinths_or_copings_and_no_other_class() -> None:
    low, high = (detailed(box("wall", (12.0, 0.3, height))) for height in (0.8, 2.5))
    assert "paving" in materials(low)
    assert "concrete" in materials(high)
    assert {p.label for p in low + high} == {"wall"}


def test_a_thick_block_stays_a_block() -> None:
    (part,) = detailed(box("fence", (4.0, 3.0, 1.5)))
    assert (part.size, part.material) == ((4.0, 3.0, 1.5), "wood")


def test_the_fences_of_a_clustering_send_back_most_rays() -> None:
    pieces = [box("fence", (2.5, 0.3, 1.2), at=(15, 3 * k, 0), id=f"fence_{k}") for k in range(20)]
    made = detailed(*pieces, source="point cloud")
    assert {p.material for p in made} == {"wood"}
    assert not any(p.extinction for p in made)
