"""The smallest network of the paper's kind learns to heed a layout, in half a minute."""

import itertools
from pathlib import Path

import numpy as np

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.evaluation import loss_by_other_layouts, unseen_streets, untrained_weights
from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.networks import weight_file
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig, streets
from lidardraft.training.denoising import DenoisingConfig, train_denoiser
from lidardraft.training.sources import PairFolder

SENSOR = Sensor(name="small", elevations=tuple(np.deg2rad(2 - 1.7 * np.arange(16)).tolist()), columns=128)
DENOISER = DenoiserConfig(
    cell=(2, 4),
    widths=(16, 16, 32, 32),
    strides=(1, 2, 2, 1),
    dilations=(1, 1, 1, 2),
    condition=("depth", "class"),
)
CONFIG = DenoisingConfig(denoiser=DENOISER, steps=100, batch=8, learning_rate=0.02, warmup=20)
HEEDS = 1.01  # of the loss by other layouts over that by their own


def test_a_minute_of_training_is_enough_to_heed_layouts_of_unseen_streets(tmp_path: Path) -> None:
    found = itertools.islice(streets(7, StreetConfig(sensor=SENSOR, poses_per_street=1, simulated=True)), 24)
    pairs = ((Pair(pair.scan, pair.condition_image, pair.simulated), {}) for pair in found if pair.simulated)
    list(write_pairs(tmp_path / "pairs", pairs))
    list(train_denoiser(CONFIG, PairFolder(tmp_path / "pairs"), tmp_path / "run"))
    trained = weight_file.load(tmp_path / "run" / "weights.safetensors", Denoiser)
    unseen = unseen_streets(6, sensor=SENSOR)
    scans, images = [pair.scan for pair in unseen], [pair.condition_image for pair in unseen]
    assert loss_by_other_layouts(trained, scans, images) > HEEDS
    assert loss_by_other_layouts(untrained_weights(trained), scans, images) <= HEEDS
