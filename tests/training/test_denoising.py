import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import torch
from box_pairs import SENSOR, make_pair, noted
from safetensors.torch import load_file

from lidardraft.diffusion.channels import RAY_CHANNELS, STATE_CHANNELS
from lidardraft.diffusion.codec import encode_scan
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.errors import FormatError, TrainingError
from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.networks import weight_file
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Blocked, Sensor
from lidardraft.training import denoising, recipes
from lidardraft.training.denoising import DenoisingConfig, train_denoiser
from lidardraft.training.processes import ALONE
from lidardraft.training.sources import PairFolder
from lidardraft.training.stack import PairStack, as_tensors

BASE, CONTROL = (dataclasses.replace(stage, report_every=1, save_every=1000) for stage in recipes.tiny())
# with the condition beside the state
GENERATOR = dataclasses.replace(CONTROL, denoiser=dataclasses.replace(CONTROL.denoiser, controlnet=False))
STAGES = {"generator": GENERATOR, "base": BASE, "control": CONTROL}


@pytest.fixture(scope="session")
def base(pairs: PairFolder, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Weights of a short first stage."""
    run = tmp_path_factory.mktemp("base")
    list(train_denoiser(BASE, pairs, run))
    return run / "weights.safetensors"


def test_the_loss_falls(pairs: PairFolder, tmp_path: Path) -> None:
    config = dataclasses.replace(GENERATOR, steps=40, report_every=10, batch=8)
    reports = list(train_denoiser(config, pairs, tmp_path))
    assert [report.step for report in reports] == [10, 20, 30, 40]
    assert reports[-1].loss < 0.85 * reports[0].loss
    assert reports[-1].samples_per_second > 0
    log = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert [row["loss"] for row in log] == [report.loss for report in reports]
    assert weight_file.read_card(tmp_path / "weights.safetensors") == {
        "training": json.loads(json.dumps(dataclasses.asdict(config))),
        "step": 40,
        "data": pairs.source,
    }


def test_the_control_learns_and_the_base_stays(pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    config = dataclasses.replace(CONTROL, steps=30, report_every=10, batch=8)
    reports = list(train_denoiser(config, pairs, tmp_path, begin=weight_file.load(base, Denoiser)))
    assert reports[-1].loss < reports[0].loss
    before, after = load_file(base), load_file(tmp_path / "weights.safetensors")
    for name, weight in before.items():
        assert torch.equal(after[name], weight), name
    copied = {name: after[f"controlnet.{name.removeprefix('network.')}"] for name in before if "encoder" in name}
    assert any(not torch.equal(before[name], weight) for name, weight in copied.items())


def test_the_control_uses_the_condition(pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    list(
        train_denoiser(
            dataclasses.replace(CONTROL, learning_rate=0.1), pairs, tmp_path, begin=weight_file.load(base, Denoiser)
        )
    )
    denoiser = weight_file.load(tmp_path / "weights.safetensors", Denoiser)
    x, sigma, rays = torch.randn(1, STATE_CHANNELS, 16, 128), torch.ones(1), torch.zeros(RAY_CHANNELS, 16, 128)
    condition = torch.rand(1, STATE_CHANNELS, 16, 128)
    with torch.no_grad():
        denoised, mirrored, free = (
            denoiser.denoise(x, sigma, rays, given, wraps=True) for given in (condition, condition.flip(-1), None)
        )
    assert not torch.allclose(denoised, mirrored, atol=1e-4)
    assert not torch.allclose(denoised, free, atol=1e-4)


def test_at_first_only_the_zero_convolutions_learn(pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    config = dataclasses.replace(CONTROL, steps=4, zero_conv_steps=4)
    list(train_denoiser(config, pairs, tmp_path, begin=weight_file.load(base, Denoiser)))
    before, after = load_file(base), load_file(tmp_path / "weights.safetensors")
    for name in before:
        if name.startswith("network.encoder."):
            assert torch.equal(after[f"controlnet.{name.removeprefix('network.')}"], before[name]), name
    begin = weight_file.load(base, Denoiser)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        fresh = begin.with_controlnet(config.denoiser).state_dict()
    changed = {name for name in fresh if not torch.equal(fresh[name], after[name])}
    assert changed == {f"controlnet.leave.{stage}.{part}" for stage in range(5) for part in ("weight", "bias")}
    # and then all of them
    list(train_denoiser(dataclasses.replace(config, steps=6), pairs, tmp_path, begin=weight_file.load(base, Denoiser)))
    later = load_file(tmp_path / "weights.safetensors")
    assert not torch.equal(later["controlnet.gain.0.bias"], after["controlnet.gain.0.bias"])
    assert not torch.equal(later["controlnet.encoder.stem.weight"], after["controlnet.encoder.stem.weight"])


@pytest.mark.parametrize("stage", ["generator", pytest.param("base", marks=pytest.mark.slow), "control"])
def test_a_run_in_slices_is_the_run_in_one(stage: str, pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    config = dataclasses.replace(STAGES[stage], steps=8, save_every=3)

    def denoiser() -> Denoiser | None:
        return weight_file.load(base, Denoiser) if stage == "control" else None

    whole = list(train_denoiser(config, pairs, tmp_path / "whole", begin=denoiser()))
    first = []
    for report in train_denoiser(config, pairs, tmp_path / "sliced", begin=denoiser()):
        first.append(report)
        if report.step == 5:  # interrupted two steps after the state was saved
            break
    rest = list(train_denoiser(config, pairs, tmp_path / "sliced", begin=denoiser()))
    assert [report.step for report in rest] == [4, 5, 6, 7, 8]
    assert [report.loss for report in first[:3] + rest] == [report.loss for report in whole]
    one, other = (load_file(tmp_path / run / "weights.safetensors") for run in ("whole", "sliced"))
    assert all(torch.equal(one[name], other[name]) for name in one)
    assert list(train_denoiser(config, pairs, tmp_path / "sliced", begin=denoiser())) == []


def test_a_sensor_that_is_no_whole_cells_is_refused(tmp_path: Path) -> None:
    odd = Sensor(name="odd", elevations=SENSOR.elevations, columns=66)
    list(write_pairs(tmp_path / "pairs", [noted(0, odd)]))
    with pytest.raises(TrainingError, match=r"odd is \(16, 66\); this recipe needs multiples of \(4, 8\)"):
        next(train_denoiser(BASE, PairFolder(tmp_path / "pairs"), tmp_path / "run"))
    assert not (tmp_path / "run").exists()


def test_a_pair_that_is_not_finite_is_refused_before_it_is_learned_from() -> None:
    pair = make_pair(0)
    intensity = pair.scan.intensity.copy()
    intensity[3, 7] = np.nan
    broken = pair._replace(scan=dataclasses.replace(pair.scan, intensity=intensity))
    with pytest.raises(FormatError, match="a pair holds an intensity that is not finite"):
        broken.compact()


def batch(config: DenoisingConfig, source: PairFolder, step: int = 0) -> denoising._Batch:
    return denoising._batch(config, step, source=source, processes=ALONE, device=torch.device("cpu"))


@pytest.mark.parametrize("span", [2 * np.pi, 2.0])
def test_a_full_turn_is_learned_as_a_ring(span: float, tmp_path: Path) -> None:
    sensor = dataclasses.replace(SENSOR, azimuth_start=span / 2, azimuth_span=span)
    list(write_pairs(tmp_path, [noted(0, sensor)]))
    assert batch(GENERATOR, PairFolder(tmp_path)).wraps == (span > 6)


def test_half_of_the_batches_are_mirrored(pairs: PairFolder) -> None:
    one = dataclasses.replace(GENERATOR, batch=1, thinnings=(1,))
    mirrored = []
    for step in range(12):
        clean, _, _, rays, condition, _ = batch(one, pairs, step)
        assert condition is not None
        images = {name: rows[0].numpy() for name, rows in pairs.stack(step, 1).images.items()}
        unsigned = {name: rows.view(np.uint16) if rows.dtype == np.int16 else rows for name, rows in images.items()}
        scan = Pair.from_compact(SENSOR, unsigned).scan
        columns = {name: getattr(scan, name)[:, ::-1] for name in ("depth", "label", "instance", "intensity")}
        # mirrored before it is encoded: a pixel without a return has the depth of the one to its left in both
        mirror_image = RangeImage(sensor=scan.sensor, **columns)
        mirrored.append(bool(np.array_equal(clean[0].numpy(), encode_scan(mirror_image))))
        assert mirrored[-1] or np.array_equal(clean[0].numpy(), encode_scan(scan))
        # what belongs together is turned together
        both = (clean[0, 2] > 0) & (condition[0, 2] > 0)
        assert (clean[0, 0] - condition[0, 0])[both].abs().median() < 0.01
        assert rays.shape == (RAY_CHANNELS, 16, 128)
    assert 0 < sum(mirrored) < 12


@pytest.mark.parametrize("blocked", [(), (((-0.5, 0.5),),) * 16])
def test_a_thinned_scan_is_that_of_a_sensor_with_every_second_beam_and_column(blocked: Blocked) -> None:
    sensor = dataclasses.replace(SENSOR, blocked=blocked, azimuth_offsets=tuple(np.linspace(0, 0.1, 16).tolist()))
    hidden = sensor.blocked_pixels
    pair = make_pair(0, sensor)
    scan = Pair.from_compact(sensor, pair.compact()).scan
    stack = PairStack.of(sensor, as_tensors({name: rows[None] for name, rows in pair.compact().items()}))
    few = stack.thinned(2)
    assert few.sensor.shape == few.rays.shape[1:] == (8, 64)
    assert stack.thinned(1) is stack
    assert few.sensor.elevations == sensor.elevations[::2]
    assert few.sensor.azimuth_offsets == sensor.azimuth_offsets[::2]
    assert (few.sensor.blocked_pixels == hidden[::2, ::2]).mean() > 0.98  # half a column off
    assert few.sensor.blocked_pixels.any() == bool(blocked)
    # the same ground, in other numbers of beams and columns
    seen, expected = scan.valid[::2, ::2], encode_scan(scan)[:, ::2, ::2]
    np.testing.assert_array_equal(few.states()[0].numpy()[:, seen], expected[:, seen])


def test_a_thinned_step_learns_from_more_scans_of_fewer_pixels(pairs: PairFolder) -> None:
    shapes = set()
    for step in range(8):
        clean, sigma, noise, rays, condition, _ = batch(GENERATOR, pairs, step)
        assert condition is not None
        assert clean.shape == noise.shape
        assert len(sigma) == len(clean) == len(condition)
        assert rays.shape[1:] == condition.shape[2:] == clean.shape[2:]
        shapes.add(tuple(clean.shape))
    assert shapes == {(4, STATE_CHANNELS, 16, 128), (16, STATE_CHANNELS, 8, 64)}


def test_weights_that_see_a_condition_go_on_from_a_base(pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    begin = weight_file.load(base, Denoiser)
    fresh, *_ = train_denoiser(dataclasses.replace(GENERATOR, steps=1), pairs, tmp_path / "fresh")
    further, *_ = train_denoiser(dataclasses.replace(GENERATOR, steps=1), pairs, tmp_path / "further", begin=begin)
    assert further.loss < fresh.loss
    assert weight_file.load(tmp_path / "further" / "weights.safetensors", Denoiser).config == GENERATOR.denoiser


def test_a_base_of_another_shape_is_refused(pairs: PairFolder, tmp_path: Path) -> None:
    other = Denoiser.from_config(dataclasses.replace(BASE.denoiser, refine_units=2))
    with pytest.raises(TrainingError, match=r"are of another form: refine_units is 2, not 1$"):
        next(train_denoiser(CONTROL, pairs, tmp_path, begin=other))
    with pytest.raises(TrainingError, match="a ControlNet needs a base"):
        next(train_denoiser(CONTROL, pairs, tmp_path))
