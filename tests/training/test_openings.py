"""What of a street is left open at random, against the classes of its condition image."""

import dataclasses
from collections import Counter

import numpy as np
import pytest
from box_pairs import SENSOR

from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.semantics import BY_NAME
from lidardraft.training.denoising import sample_opening

LAYOUT = Layout(
    (
        Primitive(shape="plane", center=(0, 0, -0.1), size=(99, 99, 0), label="terrain", id="terrain"),
        Primitive(shape="plane", center=(0, 0, 0), size=(99, 8, 0), label="road", id="road"),
        Primitive(shape="box", center=(8, 0, 0.8), size=(4, 2, 1.6), label="car", id="car", instance=1),
        Primitive(shape="box", center=(0, 12, 3), size=(20, 4, 6), label="building", id="house"),
    )
)
CLOSED = {BY_NAME[name].id: name for name in ("road", "car", "building")}
OPEN = [BY_NAME[name].id for name in ("none", "terrain")]


@pytest.fixture(scope="module")
def image() -> RangeImage:
    found = raycast(LAYOUT, SENSOR)
    assert set(np.unique(found.label)) == {*OPEN, *CLOSED}
    return found


def kind_of(opening: np.ndarray, label: np.ndarray) -> str:
    """A sector, which is one piece of the ring, all but one, or the classes that are not open."""
    if opening.all():
        return "everything"
    if (opening == opening[:1]).all():
        assert np.count_nonzero(opening[0] != np.roll(opening[0], 1)) == 2
        return "a sector" if opening[0].mean() <= 0.5 else "all but a sector"
    closed = np.unique(label[~opening])
    np.testing.assert_array_equal(opening, ~np.isin(label, closed))
    return "all but " + ", ".join(CLOSED[id] for id in closed.tolist())


def test_each_kind_occurs_in_its_share(image: RangeImage) -> None:
    kinds = Counter(kind_of(sample_opening(image, np.random.default_rng(seed)), image.label) for seed in range(2000))
    shares = {
        "a sector": 0.2,
        "all but a sector": 0.15,
        "everything": 0.1,
        "all but car": 0.15 * 0.7 * 0.7,
        "all but building, car": 0.15 * 0.7 * 0.3,
        "all but road, car": 0.15 * 0.3 * 0.7 + 0.2 * 0.7,
        "all but road, building, car": 0.15 * 0.3 * 0.3 + 0.2 * 0.3 + 0.2,  # filler alone is open too
    }
    assert kinds.keys() == shares.keys()
    for kind, share in shares.items():
        assert kinds[kind] / 2000 == pytest.approx(share, abs=0.03), kind


def test_a_narrow_sensor_is_never_all_open_by_sectors_and_never_all_given(image: RangeImage) -> None:
    narrow = RangeImage.unchecked(
        dataclasses.replace(SENSOR, azimuth_span=np.pi / 6), depth=image.depth, label=image.label
    )
    open_shares = [sample_opening(narrow, np.random.default_rng(seed)).mean() for seed in range(200)]
    assert sum(share == 1 for share in open_shares) < 200 * 0.2  # of all, one in ten
    assert min(open_shares) > 0
