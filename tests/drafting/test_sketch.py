import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from drawn_sketches import DrawnBox, DrawnLine, Hand, painted
from lidardraft import Layout, layout_from_sketch
from lidardraft.errors import FormatError, LayoutError
from lidardraft.scene.check import check
from lidardraft.semantics import BY_NAME

EXAMPLES = Path(__file__).parents[2] / "examples" / "sketches"
CAR = DrawnBox("car", (8.0, 1.8), 4.2, 1.8, 0.1)


def counted(layout: Layout) -> dict[str, int]:
    return {name: int(count) for name, count in (line.split(": ") for line in layout.provenance["understood"])}


def test_the_painted_example() -> None:
    layout = layout_from_sketch(EXAMPLES / "crossroads.png", scale_bar=10.0)
    assert check(layout) == []
    assert counted(layout) == {
        **{"road": 3, "sidewalk": 4, "building": 2, "house": 2, "tree": 3, "car": 3, "bus": 1, "bicycle": 1},
        **{"person": 2, "traffic-light": 1, "pole": 1, "hedge": 1, "wall": 1, "fence": 1},
    }
    assert layout.provenance["ego"] == "marked"
    bus = layout["bus_1"]
    np.testing.assert_allclose(bus.center[:2], (29.0 + 8.0, 1.9 + 1.9), atol=0.4)
    assert abs(math.remainder(bus.yaw - math.pi, math.tau)) < math.radians(5)  # it comes


def test_the_example_of_named_shapes() -> None:
    layout = layout_from_sketch(EXAMPLES / "bend.svg")
    assert check(layout) == []
    assert counted(layout) == {
        **{"road": 2, "sidewalk": 1, "building": 1, "house": 2, "tree": 9, "car": 4, "bus": 1, "van": 1},
        **{"bicycle": 1, "person": 1, "street-light": 1, "hedge": 1, "wall": 1},
    }
    assert layout["road_1"].shape == "mesh"
    assert layout.notes == ("ignored: text: not read",)
    rider = [box for box in layout.boxes() if box.label == "rider"]
    assert len(rider) == 1


def test_the_same_seed_gives_the_same_layout_and_another_other_heights() -> None:
    pixels = painted([DrawnBox("building", (20.0, 10.0), 10.0, 8.0, 0.2)])
    one, same, other = (layout_from_sketch(pixels, metres_per_pixel=0.1, seed=seed) for seed in (1, 1, 2))
    assert one.to_json() == same.to_json()
    assert one["house_1"].size[:2] == other["house_1"].size[:2]
    assert one["house_1"].size[2] != other["house_1"].size[2]


@pytest.mark.parametrize("seed", range(4))
def test_what_was_drawn_is_found_again(seed: int) -> None:
    """Boxes apart from each other, of several classes, with the wobble of a hand."""
    rng, shapes = np.random.default_rng(seed), []
    for k, label in enumerate(("car", "bus", "building", "truck", "car", "car", "building", "motorcycle")):
        size = BY_NAME[label].size or (12.0, 9.0, 6.0)
        place = (float(rng.uniform(-28, 28)), 8.0 * k - 28 + float(rng.uniform(-1, 1)))
        turn = float(rng.uniform(-0.3, 0.3)) if label != "building" else 0.0
        shapes.append(DrawnBox(label, place, size[0] * (0.5 if label == "building" else 1), min(size[1], 6), turn))
    layout = layout_from_sketch(painted(shapes, hand=Hand(seed, 0.06)), metres_per_pixel=0.1)
    standing = [primitive for primitive in layout if primitive.label not in ("terrain", "road")]
    assert len(standing) == len(shapes)
    assert [primitive.id for primitive in layout if primitive.open] == ["terrain"]  # what nothing is painted on
    for shape in shapes:
        near = min(standing, key=lambda one: math.dist(one.center[:2], shape.center))
        assert near.label == shape.label
        assert math.dist(near.center[:2], shape.center) < 0.25
        if shape.label != "building":
            assert abs(math.remainder(near.yaw - shape.yaw, math.pi)) < math.radians(6)


def test_a_file_is_read_as_its_pixels_and_what_is_transparent_is_paper(tmp_path: Path) -> None:
    pixels = painted([CAR, DrawnLine("road", np.array([(-40.0, 0.0), (40.0, 0.0)]), 7.0), CAR])
    opaque = np.where((pixels == 255).all(axis=2), 0, 255).astype(np.uint8)
    Image.fromarray(pixels).save(tmp_path / "a.png")
    Image.fromarray(np.dstack([np.where(opaque[..., None] > 0, pixels, 0), opaque])).save(tmp_path / "b.png")
    Image.fromarray(pixels).save(tmp_path / "c.jpg", quality=90)
    first, second, third = (
        layout_from_sketch(tmp_path / name, metres_per_pixel=0.1) for name in ("a.png", "b.png", "c.jpg")
    )
    assert second.primitives == first.primitives
    assert counted(third) == counted(first) == {"car": 1, "road": 1}


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.svg", b"<svg/>", "a.svg: the sketch has no scale"),
        (
            "a.svg",
            b'<svg><line id="scale 5 m" x2="9"/><rect id="q" width="1" height="1"/></svg>',
            "a.svg: the sketch shows nothing of a class; rect 'q': neither",
        ),
        ("a.svg", b"\xff\xfe<\x00s\x00", "a.svg is not text in UTF-8"),
        ("a.png", b"car", "a.png: not a whole picture"),
    ],
)
def test_the_file_that_is_wrong_is_named(tmp_path: Path, name: str, content: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises((FormatError, LayoutError), match=said):
        layout_from_sketch(tmp_path / name)


@pytest.mark.parametrize(
    ("pixels", "options", "said"),
    [
        *((painted([CAR]), {"metres_per_pixel": wrong}, "metres_per_pixel is") for wrong in (0.0, math.nan)),
        (painted([CAR]), {"scale_bar": -1.0}, "scale_bar is"),
        *((painted([CAR]), {"seed": seed}, "seed is") for seed in (-1, 1.5, "a")),
        *((np.zeros(shape), {}, r"must be uint8 \[H, W, 3\]") for shape in ((4, 4), (4, 4, 3), (0, 4, 3))),
        (np.full((60, 60, 3), 255, np.uint8), {}, "shows nothing of a class"),
    ],
)
def test_what_cannot_be_drawn(pixels: np.ndarray, options: dict[str, float], said: str) -> None:
    with pytest.raises(LayoutError, match=said):
        layout_from_sketch(pixels, **{"metres_per_pixel": 0.1} | options)  # type: ignore[arg-type]
