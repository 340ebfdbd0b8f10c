import numpy as np
import pytest
from PIL import Image

from lidardraft.errors import CheckpointError
from lidardraft.perception.semantic_network import SemanticNetwork
from lidardraft.semantics import BY_NAME

pytest.importorskip("transformers")
import tiny_networks
import transformers

PIXELS = np.random.default_rng(0).integers(0, 256, (64, 176, 3), dtype=np.uint8)
BUILDERS = [tiny_networks.segformer, tiny_networks.mask2former, tiny_networks.eomt, tiny_networks.oneformer]
IDS = {name: BY_NAME[name.replace(" ", "-")].id if name != "sky" else 0 for name in tiny_networks.NAMES.values()}


@pytest.mark.parametrize("build", BUILDERS)
def test_classes_are_what_the_library_s_own_pipeline_gives(tmp_path, build):
    folder = build(tmp_path / "network")
    found = SemanticNetwork.from_pretrained(folder)(PIXELS)
    pipeline = transformers.pipeline("image-segmentation", model=str(folder))
    theirs = np.full(PIXELS.shape[:2], 255, dtype=np.uint8)
    for part in pipeline(Image.fromarray(PIXELS), subtask="semantic"):
        theirs[np.asarray(part["mask"]) > 0] = IDS[part["label"]]
    assert found.dtype == np.uint8
    np.testing.assert_array_equal(found, theirs)


def test_a_wide_picture_is_put_together_from_squares(tmp_path):
    """EoMT sees squares: what changes in the right one changes nothing on the left."""
    network = SemanticNetwork.from_pretrained(tiny_networks.eomt(tmp_path / "network"))
    changed = PIXELS.copy()
    changed[:, 130:] = 255 - changed[:, 130:]
    assert network(PIXELS).shape == (64, 176)
    np.testing.assert_array_equal(network(changed)[:, :50], network(PIXELS)[:, :50])


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
    with pytest.raises(CheckpointError, match=r"its 2 labels \(cat, sofa, ...\) name no class of ours"):
        SemanticNetwork.from_pretrained(folder)
