import numpy as np
import pytest
import torch
from PIL import Image

from lidardraft.errors import CheckpointError
from lidardraft.perception.depth_network import DepthNetwork

pytest.importorskip("transformers")
import tiny_networks
import transformers

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
