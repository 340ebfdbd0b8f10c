import os
import subprocess
import sys
import threading
from functools import cache
from http.server import BaseHTTPRequestHandler, HTTPServer

import numpy as np
import pytest
import tiny_networks
import torch
import transformers
from PIL import Image

from lidardraft import layout_from_image, layout_from_text
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.errors import CheckpointError, LayoutError, MissingExtraError
from lidardraft.perception import picture_networks
from lidardraft.perception.mask_votes import number_objects
from lidardraft.perception.picture_networks import DepthNetwork, MaskNetwork, SemanticNetwork
from lidardraft.semantics import BY_NAME
from rendered_pictures import render

pytest.importorskip("transformers")

PIXELS = np.random.default_rng(0).integers(0, 256, (90, 160, 3), dtype=np.uint8)


@pytest.mark.parametrize("build", [tiny_networks.depth_anything, tiny_networks.glpn])
def test_depth_is_what_the_library_s_own_pipeline_gives(tmp_path, build):
    folder = build(tmp_path / "network")
    depth = DepthNetwork.from_pretrained(folder)(PIXELS)
    theirs = transformers.pipeline("depth-estimation", model=str(folder))(Image.fromarray(PIXELS))["predicted_depth"]
    assert depth.shape == (90, 160)
    assert depth.dtype == np.float32
    np.testing.assert_allclose(depth, theirs.numpy(), rtol=1e-5)


def test_depth_without_a_unit_is_refused(tmp_path):
    folder = tiny_networks.depth_anything(tmp_path / "network", depth_estimation_type="relative", max_depth=None)
    with pytest.raises(CheckpointError, match="gives relative depth; metric depth is needed"):
        DepthNetwork.from_pretrained(folder)


def test_depth_as_far_as_the_network_can_tell_is_not_known(tmp_path):
    """As the sky is: with large weights in its last layer the network says 80 m, its most, where it says anything."""
    network = DepthNetwork.from_pretrained(tiny_networks.depth_anything(tmp_path / "network"))
    with torch.no_grad():
        network.network.head.conv3.bias.fill_(10.0)
    assert not network(PIXELS).any()


WIDE = np.random.default_rng(0).integers(0, 256, (64, 176, 3), dtype=np.uint8)
BUILDERS = [tiny_networks.segformer, tiny_networks.mask2former, tiny_networks.eomt, tiny_networks.oneformer]
IDS = {name: BY_NAME[name.replace(" ", "-")].id if name != "sky" else 0 for name in tiny_networks.NAMES.values()}


@pytest.mark.parametrize("build", BUILDERS)
def test_classes_are_what_the_library_s_own_pipeline_gives(tmp_path, build):
    folder = build(tmp_path / "network")
    found = SemanticNetwork.from_pretrained(folder)(WIDE)
    pipeline = transformers.pipeline("image-segmentation", model=str(folder))
    theirs = np.full(WIDE.shape[:2], 255, dtype=np.uint8)
    for part in pipeline(Image.fromarray(WIDE), subtask="semantic"):
        theirs[np.asarray(part["mask"]) > 0] = IDS[part["label"]]
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(found, theirs)


def test_a_wide_picture_is_put_together_from_squares(tmp_path):
    """EoMT sees squares: what changes in the right one changes nothing on the left."""
    network = SemanticNetwork.from_pretrained(tiny_networks.eomt(tmp_path / "network"))
    changed = WIDE.copy()
    changed[:, 130:] = 255 - changed[:, 130:]
    assert network(WIDE).shape == (64, 176)
    np.testing.assert_array_equal(network(changed)[:, :50], network(WIDE)[:, :50])


@pytest.mark.parametrize(
    ("names", "classes"),
    [
        ({0: "tree", 1: "road;route", 2: "sky", 3: "minibus"}, ["vegetation", "road", None, "bus"]),
        ({k: f"LABEL_{k}" for k in range(19)}, ["road", "sidewalk", "building", "wall", "fence", "pole"]),
    ],
)
def test_names_of_labels_say_their_classes(tmp_path, names, classes):
    network = SemanticNetwork.from_pretrained(tiny_networks.segformer(tmp_path / "network", names))
    assert len(network.classes) == len(names)
    assert network.classes.tolist()[: len(classes)] == [BY_NAME[name].id if name else 0 for name in classes]


def test_labels_that_name_no_class_are_refused(tmp_path):
    folder = tiny_networks.segformer(tmp_path / "network", {0: "cat", 1: "sofa"})
    with pytest.raises(CheckpointError, match=r"its 2 labels \(cat, sofa, ...\) name no known class"):
        SemanticNetwork.from_pretrained(folder)


CAR, ROAD, BUS = (BY_NAME[name].id for name in ("car", "road", "bus"))
LABELS = np.full((40, 60), ROAD)
LABELS[10:20, 10:30] = CAR


def mask(rows, columns):
    found = np.zeros(LABELS.shape, dtype=bool)
    found[slice(*rows), slice(*columns)] = True
    return found


def test_each_mask_of_a_thing_is_one_object():
    masks = np.stack([mask((10, 20), (10, 20)), mask((10, 20), (20, 30))])
    classes, numbers = number_objects(LABELS, masks)
    np.testing.assert_array_equal(classes, LABELS)
    assert set(numbers[10:20, 10:20].ravel()) == {1}
    assert set(numbers[10:20, 20:30].ravel()) == {2}
    assert not numbers[LABELS == ROAD].any()


def test_the_outline_is_that_of_the_mask():
    """Most of its pixels say car, so that the others are of the car too."""
    classes, numbers = number_objects(LABELS, mask((9, 20), (9, 30))[None])
    assert (classes == CAR).sum() == (numbers == 1).sum() == 11 * 21


@pytest.mark.parametrize("wrong", [mask((30, 38), (0, 60)), mask((0, 40), (0, 60)), mask((0, 0), (0, 0))])
def test_a_mask_of_the_road_or_of_everything_is_no_object(wrong):
    classes, numbers = number_objects(LABELS, wrong[None])
    np.testing.assert_array_equal(classes, LABELS)
    assert not numbers.any()


def test_what_a_better_mask_has_is_not_given_twice():
    masks = np.stack([mask((10, 20), (10, 30)), mask((12, 20), (12, 30)), mask((12, 24), (24, 34))])
    _, numbers = number_objects(LABELS, masks)
    assert set(numbers.ravel()) == {0, 1}


def test_the_objects_of_a_network_are_of_the_kinds_that_were_seen(tmp_path):
    network = MaskNetwork.from_pretrained(tiny_networks.sam(tmp_path / "network"))
    pixels = np.random.default_rng(0).integers(0, 256, (40, 60, 3), dtype=np.uint8)
    masks, scores = network._masks(pixels, np.array([(15, 15), (24, 12), (16, 11)]))
    assert masks.shape[1:] == (40, 60)
    assert len(masks) == len(scores)
    classes, numbers = network(pixels, LABELS)
    assert set(classes.ravel()) <= {CAR, ROAD}
    assert numbers.shape == (40, 60)


def test_masks_of_a_good_score_are_kept(tmp_path):
    network = MaskNetwork.from_pretrained(tiny_networks.sam(tmp_path / "network"))
    with torch.no_grad():
        network.network.mask_decoder.iou_prediction_head.proj_out.bias.fill_(1.0)
    pixels = np.random.default_rng(0).integers(0, 256, (40, 60, 3), dtype=np.uint8)
    points = np.array([(x, y) for x in range(0, 60, 10) for y in range(0, 40, 10)])
    masks, scores = network._masks(pixels, points)
    assert masks.shape == (24, 40, 60)
    assert scores.min() >= 0.8


def test_a_picture_without_things_is_not_asked_about():
    network = MaskNetwork("none", None, None)
    _, numbers = network(np.zeros((40, 60, 3), np.uint8), np.full((40, 60), ROAD))
    assert not numbers.any()


def test_numbers_of_masks_mean_the_same_as_masks() -> None:
    labels = np.full((6, 9), ROAD)
    labels[2:5, 1:8] = CAR
    numbers = np.zeros((6, 9), dtype=np.uint32)
    numbers[2:5, 1:4], numbers[1:5, 4:8] = 7, 30  # the second reaches a row over its car
    classes, objects = number_objects(labels, numbers)
    again = number_objects(labels, np.stack([numbers == 7, numbers == 30]))
    np.testing.assert_array_equal(classes, again[0])
    np.testing.assert_array_equal(objects, again[1])
    assert set(objects.ravel()) == {0, 1, 2}
    assert (classes == CAR).sum() == 9 + 16


def test_without_the_extra_one_line_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "transformers", None)
    with pytest.raises(
        MissingExtraError, match=r"transformers is not installed; run: pip install 'lidardraft\[image\]'"
    ):
        picture_networks.load_pretrained("depth network", "AutoImageProcessor", "anything")


@pytest.mark.parametrize("name", ["nobody/nothing", "not an id", "/nowhere/at/all"])
def test_what_is_not_there_is_one_line(monkeypatch, name):
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_OFFLINE", True)
    with pytest.raises(CheckpointError, match=f"depth network '{name}' cannot be loaded: ") as raised:
        picture_networks.load_network("depth network", "AutoModelForDepthEstimation", name, "cpu")
    assert "\n" not in str(raised.value)


@pytest.mark.slow
def test_a_hub_that_does_not_answer_is_asked_once_and_gets_one_line(tmp_path):
    """transformers asks six times, for half a minute, and logs each."""
    asked = []

    class Broken(BaseHTTPRequestHandler):
        def log_request(self, *_):
            asked.append(self.path)

        def log_message(self, *_):
            pass

    Image.fromarray(PIXELS).save(tmp_path / "photo.png")
    with HTTPServer(("127.0.0.1", 0), Broken) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        environment = os.environ | {"HF_ENDPOINT": f"http://127.0.0.1:{server.server_port}", "HF_HOME": str(tmp_path)}
        command = [sys.executable, "-m", "lidardraft", "draft", "--image", "photo.png", "--hfov", "70", "-o", "a.json"]
        ended = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        server.shutdown()
    assert ended.returncode == 2
    assert len(ended.stderr.splitlines()) == 1, ended.stderr
    assert "--depth FILE, --semantics FILE and --masks FILE need no network" in ended.stderr
    assert sum("cityscapes" in path for path in asked) == 1


def test_a_folder_without_weights_or_with_broken_ones_is_one_line(tmp_path):
    folder = tiny_networks.glpn(tmp_path / "glpn")
    weights = folder / "model.safetensors"
    weights.write_bytes(weights.read_bytes()[:100])
    with pytest.raises(CheckpointError, match="cannot be loaded: ") as broken:
        picture_networks.load_network("depth network", "AutoModelForDepthEstimation", folder, "cpu")
    weights.unlink()
    with pytest.raises(CheckpointError, match=r"cannot be loaded: .*safetensors") as missing:
        picture_networks.load_network("depth network", "AutoModelForDepthEstimation", folder, "cpu")
    (folder / "config.json").write_text("{")
    with pytest.raises(CheckpointError, match="cannot be loaded: "):
        picture_networks.load_network("depth network", "AutoModelForDepthEstimation", folder, "cpu")
    assert "\n" not in str(broken.value) + str(missing.value)


def test_pickled_weights_are_not_read(tmp_path):
    folder = tiny_networks.glpn(tmp_path / "glpn")
    (folder / "model.safetensors").unlink()
    torch.save({}, folder / "pytorch_model.bin")
    with pytest.raises(CheckpointError, match=r"cannot be loaded: .*safetensors"):
        picture_networks.load_network("depth network", "AutoModelForDepthEstimation", folder, "cpu")


@cache
def two_cars():
    return render(layout_from_text("two cars 12 m ahead", seed=0), Pinhole.from_hfov(np.deg2rad(80), 480, 160))


def test_layouts_ask_the_networks_of_folders(tmp_path):
    picture = two_cars()
    camera = picture.camera
    known = {
        "depth": picture.depth,
        "semantics": picture.labels,
        "intrinsics": (camera.fx, camera.fy, camera.cx, camera.cy),
    }
    semantics = tiny_networks.segformer(tmp_path / "semantics", {0: "road", 1: "car"})
    layout = layout_from_image(picture.pixels, **(known | {"semantics": semantics}))
    assert {p.label for p in layout if p.id != "ground"} <= {"road", "car"}
    assert layout.provenance["semantics"] == str(semantics)
    masks = tiny_networks.sam(tmp_path / "masks")
    labels = {p.label for p in layout_from_image(picture.pixels, **known)}
    assert {p.label for p in layout_from_image(picture.pixels, **(known | {"masks": masks}))} == labels
    with pytest.raises(LayoutError, match="no plane of the ground"):  # random weights see 40 m everywhere
        layout_from_image(picture.pixels, **(known | {"depth": tiny_networks.depth_anything(tmp_path / "depth")}))


def test_a_network_may_be_any_function():
    picture = two_cars()
    layout = layout_from_image(
        picture.pixels,
        depth=lambda pixels: np.where(pixels.any(axis=2), picture.depth, 0),
        semantics=lambda _: picture.labels,
        intrinsics=(picture.camera.fx, picture.camera.fy, picture.camera.cx, picture.camera.cy),
    )
    assert {box.label for box in layout.boxes()} == {"car"}
