import numpy as np
import pytest

from lidardraft.perception.mask_network import MaskNetwork
from lidardraft.perception.mask_votes import number_objects
from lidardraft.semantics import BY_NAME

pytest.importorskip("transformers")
import tiny_networks

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
    import torch

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
