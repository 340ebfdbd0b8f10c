import importlib.util

import numpy as np
import pytest

from lidardraft import layout_from_image, layout_from_text
from lidardraft.errors import CheckpointError, LayoutError
from lidardraft.perception import pretrained
from rendered_pictures import render

pytest.importorskip("transformers")
import tiny_networks


def test_without_the_extra_one_line_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(pretrained, "find_spec", lambda name: importlib.util.find_spec(f"no_{name}"))
    with pytest.raises(CheckpointError, match=r"need the extra `image`: pip install 'lidardraft\[image\]'"):
        pretrained.load_pretrained("depth network", "AutoImageProcessor", "anything")


@pytest.mark.parametrize("name", ["nobody/nothing", "not an id", "/nowhere/at/all"])
def test_what_is_not_there_is_one_line(monkeypatch, name):
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_OFFLINE", True)
    with pytest.raises(CheckpointError, match=f"depth network '{name}' cannot be loaded: ") as raised:
        pretrained.load_network("depth network", "AutoModelForDepthEstimation", name, "cpu")
    assert "\n" not in str(raised.value)


def test_a_folder_without_weights_or_with_broken_ones_is_one_line(tmp_path):
    folder = tiny_networks.glpn(tmp_path / "glpn")
    weights = folder / "model.safetensors"
    weights.write_bytes(weights.read_bytes()[:100])
    with pytest.raises(CheckpointError, match="cannot be loaded: ") as broken:
        pretrained.load_network("depth network", "AutoModelForDepthEstimation", folder, "cpu")
    weights.unlink()
    with pytest.raises(CheckpointError, match=r"cannot be loaded: .*safetensors") as missing:
        pretrained.load_network("depth network", "AutoModelForDepthEstimation", folder, "cpu")
    (folder / "config.json").write_text("{")
    with pytest.raises(CheckpointError, match="cannot be loaded: "):
        pretrained.load_network("depth network", "AutoModelForDepthEstimation", folder, "cpu")
    assert "\n" not in str(broken.value) + str(missing.value)


def test_pickled_weights_are_not_read(tmp_path):
    import torch

    folder = tiny_networks.glpn(tmp_path / "glpn")
    (folder / "model.safetensors").unlink()
    torch.save({}, folder / "pytorch_model.bin")
    with pytest.raises(CheckpointError, match=r"cannot be loaded: .*safetensors"):
        pretrained.load_network("depth network", "AutoModelForDepthEstimation", folder, "cpu")


def test_a_network_of_another_kind_is_one_line(tmp_path):
    folder = tiny_networks.segformer(tmp_path / "segformer")
    with pytest.raises(CheckpointError, match=r"depth network .* cannot be loaded: Unrecognized configuration class"):
        pretrained.load_network("depth network", "AutoModelForDepthEstimation", folder, "cpu")


def test_a_device_that_is_not_there_is_one_line(tmp_path):
    folder = tiny_networks.glpn(tmp_path / "glpn")
    with pytest.raises(CheckpointError, match="device is 'nonsense': "):
        pretrained.load_network("depth network", "AutoModelForDepthEstimation", folder, "nonsense")


def test_layouts_ask_the_networks_of_folders(tmp_path):
    picture = render(layout_from_text("two cars 12 m ahead", seed=0))
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
    picture = render(layout_from_text("two cars 12 m ahead", seed=0))
    layout = layout_from_image(
        picture.pixels,
        depth=lambda pixels: np.where(pixels.any(axis=2), picture.depth, 0),
        semantics=lambda _: picture.labels,
        intrinsics=(picture.camera.fx, picture.camera.fy, picture.camera.cx, picture.camera.cy),
    )
    assert {box.label for box in layout.boxes()} == {"car"}
