import numpy as np
import pytest

from lidardraft.drafting.solver.object_shapes import (
    ObjectPart,
    SizeAround,
    SizeBetween,
    in_segments,
    sample_box,
    street_light_parts,
    traffic_light_parts,
    traffic_sign_parts,
    tree_parts,
    with_rider,
)


@pytest.mark.parametrize(
    "sizes", [SizeBetween((1.0, 2.0, 3.0), (1.5, 2.0, 4.0)), SizeAround((4.2, 1.8, 1.5), (0.1, 0.04, 0.08))]
)
def test_sampled_sizes_fill_their_range(sizes: SizeBetween | SizeAround) -> None:
    rng = np.random.default_rng(0)
    sampled = np.array([sizes.sample(rng) for _ in range(500)])
    low, high = np.array(sizes.smallest), np.array(sizes.largest)
    np.testing.assert_allclose(sampled.min(axis=0), low, atol=0.01 + 0.02 * (high - low).max())
    np.testing.assert_allclose(sampled.max(axis=0), high, atol=0.01 + 0.02 * (high - low).max())


def test_a_box_stands_on_the_ground() -> None:
    (box,) = sample_box(SizeBetween((1.0, 2.0, 3.0), (1.0, 2.0, 3.0)), "other", np.random.default_rng(0))
    assert box == ObjectPart("", "box", (0.0, 0.0, 1.5), (1.0, 2.0, 3.0), "other")


def test_segments_lie_end_to_end() -> None:
    strip = ObjectPart("", "box", (0.0, 0.0, 1.0), (11.0, 0.3, 2.0), "wall")
    segments = in_segments(strip)
    assert [segment.name for segment in segments] == ["1", "2", "3"]
    ends = [(s.center[0] - s.size[0] / 2, s.center[0] + s.size[0] / 2) for s in segments]
    np.testing.assert_allclose(np.ravel(ends), [-5.5, -11 / 6, -11 / 6, 11 / 6, 11 / 6, 5.5])


def test_a_rider_sits_on_what_is_ridden() -> None:
    machine, rider = with_rider(
        ObjectPart("", "box", (0.0, 0.0, 0.55), (1.8, 0.6, 1.1), "bicycle"), np.random.default_rng(0)
    )
    assert (machine.name, rider.name, rider.label) == ("bicycle", "rider", "rider")
    bottom, top = rider.center[2] - rider.size[2] / 2, rider.center[2] + rider.size[2] / 2
    assert bottom == pytest.approx(0.66)
    assert 1.6 <= top <= 1.85


@pytest.mark.parametrize(
    ("parts", "top"),
    [
        (tree_parts(8.0, 4.0, 0.3, 2.0), 8.0),
        (street_light_parts(7.0), 7.075),
        (traffic_light_parts(2.5), 3.4),
        (traffic_sign_parts(2.3, 0.7), 2.3),
    ],
)
def test_objects_on_posts_are_as_high_as_asked_and_hang_together(parts: list[ObjectPart], top: float) -> None:
    post, head = parts
    assert post.center[2] == pytest.approx(post.size[2] / 2)
    assert max(part.center[2] + part.size[2] / 2 for part in parts) == pytest.approx(top)
    assert head.center[2] - head.size[2] / 2 <= post.size[2] + 1e-9
