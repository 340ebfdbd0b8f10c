"""`lidardraft-train`, from nothing to weights; and `lidardraft evaluate`."""

import dataclasses
import os
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from lidardraft import evaluation, layout_from_text, simulate
from lidardraft.cli import main as cli
from lidardraft.cli import train
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.sensor_limits import SensorLimits
from lidardraft.formats.kitti import write_bin
from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.formats.semantickitti import write_label
from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import Segmenter
from lidardraft.pipeline import Pipeline
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetPair
from lidardraft.training import recipes

DATA = Path(os.environ.get("LIDARDRAFT_DATA", "nowhere"))
ARGV = ["street", "--recipe", "tiny", "--sensor", "small.json", "--work", "work", "-o", "tiny.safetensors"]
SHORT = ["--steps", "2", "--evaluate", "1", "--batch", "1"]


@pytest.fixture(autouse=True)
def streets_made_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same streets are scored on by every run."""
    monkeypatch.setattr(evaluation, "unseen_streets", _unseen_streets)


_make_streets = cache(evaluation.unseen_streets)


def _unseen_streets(num: int, on_street: object = None, **named: Any) -> list[StreetPair]:
    del on_street  # which moves a bar
    return _make_streets(num, **named)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (["--device", "nonsense"], "device is 'nonsense'"),
        (["--sensor", "odd.json"], "small is (16, 66); this recipe needs multiples of (4, 8)"),
        (["--data", "streets=much"], "--data is 'streets=much'; behind = there must be a number"),
        (["--data", "nowhere"], "nowhere"),
        (["--init", "nothing"], "weights are 'nothing'"),
        (["--init", "paper-small"], "are of another form: widths is (64, 96, 128, 128), not (8, 8, 16, 16)"),
        (["-o", "."], ". is a folder; the weights are a file"),
        (["--work", "small.json"], "small.json is a file; it must be a folder"),
    ],
)
def test_what_cannot_be_is_refused_before_any_work(
    wrong: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    dataclasses.replace(Sensor.load("small.json"), columns=66).save("odd.json")
    assert train.main([*ARGV, *SHORT, *wrong]) == 2
    assert message in capsys.readouterr().err
    assert not Path("work").exists()


def test_what_ships_is_scored_on_the_device_that_was_asked_for(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    devices: list[str] = []
    scored: list[dict[str, torch.Tensor]] = []
    from_pretrained, evaluate = Pipeline.from_pretrained, evaluation.evaluate

    def on_a_device(name: Path, *, device: str = "cpu", steps: int = 4) -> Pipeline:
        devices.append(device)
        return from_pretrained(name, device=device, steps=steps)

    def scores(
        pipeline: Pipeline, pairs: list[StreetPair], *, on_scan: Callable[[], object]
    ) -> Iterator[evaluation.Scores]:
        scored.append(pipeline.denoiser.state_dict())
        return evaluate(pipeline, pairs, on_scan=on_scan)

    with monkeypatch.context() as noticed:
        noticed.setattr(Pipeline, "from_pretrained", on_a_device)
        noticed.setattr(evaluation, "evaluate", scores)
        assert train.main([*ARGV, *SHORT, "--device", "cpu:0"]) == 0
    assert devices == ["cpu:0"]
    shipped = weight_file.load("tiny.safetensors", Denoiser).state_dict()
    assert all(torch.equal(scored[0][name], weight) for name, weight in shipped.items())

    card = weight_file.read_card("tiny.safetensors")
    assert [stage["step"] for stage in card["stages"]] == [2, 2]
    assert SensorLimits.from_dict(card["sensors"]) == SensorLimits.from_sensor(Sensor.load("small.json"))
    names = [scores["name"] for scores in card["scores"]]
    assert names == ["detailed scan", "other streets", "condition image", "simulated", "generated", "untrained"]
    assert train.main([*ARGV, *SHORT, "--seed", "5"]) == 2  # the run is of another seed
    assert "use another folder" in capsys.readouterr().err
    generate = ["generate", "--text", "a car ahead", "--sensor", "small.json", "--steps", "2"]
    assert cli.main([*generate, "--weights", "tiny.safetensors", "-o", "out"]) == 0


@pytest.mark.slow
def test_the_papers_stages_follow_one_another(capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["street", "--recipe", "tiny", "--sensor", "small.json", "--work", "work", "-o", "paper.safetensors"]
    assert train.main([*argv, *SHORT]) == 0
    denoiser = weight_file.load("paper.safetensors", Denoiser)
    assert denoiser.controlnet is not None
    base = weight_file.load("work/stage-1/weights.safetensors", Denoiser)
    assert base.controlnet is None
    assert weight_file.read_card("paper.safetensors")["scores"][2]["name"] == "condition image"
    capsys.readouterr()
    # the last stage alone, on the base of the weights to begin with
    go_on = ["--init", "paper.safetensors", "--sensor", "small.json", *SHORT]
    assert train.main(["street", "--recipe", "tiny", "--work", "more", "-o", "more.safetensors", *go_on]) == 0
    assert [path.name for path in Path("more").iterdir() if path.is_dir()] == ["stage-1"]
    assert train.main(["street", "--work", "wide", "-o", "wide.safetensors", *go_on]) == 2
    err = "the weights to begin with are of another form: widths is (8, 8, 16, 16), not (64, 96, 128, 128)\n"
    assert capsys.readouterr().err == f"lidardraft-train: {err}"


def test_the_controlnet_of_given_weights_learns_on(capsys: pytest.CaptureFixture[str]) -> None:
    *_, form = recipes.tiny()
    torch.manual_seed(1)
    given = Denoiser.from_config(form.denoiser)
    assert given.controlnet is not None
    with torch.no_grad():
        given.controlnet.encoder.stem.weight.neg_()  # no copy of the encoder, as after a training
        given.network.head.weight.normal_(std=0.05)  # a base that has learned
    sampling = {"steps": 3, "guidance": 1.5, "last_noise": 0.2}
    weight_file.save(given, "given.safetensors", {"sampling": sampling})
    argv = ["street", "--recipe", "tiny", "--sensor", "small.json", "--init", "given.safetensors"]
    argv += ["--batch", "1", "--evaluate", "1", "--work", "work", "-o", "further.safetensors"]
    assert train.main([*argv, "--steps", "7", "--minutes", "0.0001"]) == 0
    assert "stage-1: stopped after 0.0001 minutes; the same call goes on" in capsys.readouterr().out
    assert train.main([*argv, "--steps", "7"]) == 0
    (stage,) = (path / "weights.safetensors" for path in Path("work").iterdir() if path.is_dir())
    card, control = weight_file.read_card(stage), weight_file.load(stage, Denoiser)
    assert (card["step"], card["training"]["learning_rate"]) == (7, 0.3 * 0.01)
    learned = given.network.state_dict()
    assert all(torch.equal(learned[name], weight) for name, weight in control.network.state_dict().items())
    # the given ControlNet has learned on: the first steps are of its zero convolutions, the others small
    assert control.controlnet is not None
    moved = control.controlnet.encoder.stem.weight - given.controlnet.encoder.stem.weight
    assert 0 < moved.abs().max() < 0.1 * given.controlnet.encoder.stem.weight.abs().max()
    assert weight_file.read_card("further.safetensors")["sampling"] == sampling  # of weights of the same form
    capsys.readouterr()


def test_training_goes_on_with_given_weights_and_own_pairs(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["streets", "-n", "2", "--sensor", "small.json", "-o", "pairs", "--workers", "1"]) == 0
    data = ["--data", "pairs=3", "--data", "streets", "--sensor", "small.json"]
    argv = ["street", "--recipe", "tiny", *data, "--work", "one", "-o", "one.safetensors"]
    assert train.main([*argv, *SHORT]) == 0
    given = ["--init", "one.safetensors", "--data", "pairs", "--work", "two", "-o", "two.safetensors"]
    argv = ["street", "--recipe", "tiny", *given]
    assert train.main([*argv, *SHORT]) == 0
    capsys.readouterr()
    other = [argument.replace("one.safetensors", "two.safetensors") for argument in argv]
    assert train.main([*other, *SHORT]) == 2  # in the folder of the run from the first weights
    assert "begun with other weights (--init" in capsys.readouterr().err
    one, two = (weight_file.load(name, Denoiser) for name in ("one.safetensors", "two.safetensors"))
    assert one.config == two.config
    assert any(not torch.equal(a, b) for a, b in zip(one.parameters(), two.parameters(), strict=True))
    assert weight_file.read_card("one.safetensors")["data"].startswith(
        "75% streets of seed 0, 4 poses each, small; 25%"
    )
    capsys.readouterr()


def test_a_data_set_becomes_the_papers_training(capsys: pytest.CaptureFixture[str]) -> None:
    tiny = Sensor(name="tiny", elevations=tuple(np.deg2rad(np.linspace(2, -24, 8)).tolist()), columns=32)
    tiny.save("tiny.json")
    for name in ("velodyne", "labels"):
        Path("set/sequences/00", name).mkdir(parents=True)
    for number in range(2):
        scan = simulate(layout_from_text("a car ahead, a street with houses", seed=number), tiny, seed=number)
        write_bin(f"set/sequences/00/velodyne/{number:06d}.bin", scan.points(), scan.intensities())
        write_label(f"set/sequences/00/labels/{number:06d}.label", scan.labels(), scan.instances())
    argv = ["pairs", "--dataset", "semantickitti", "set", "--split", "train", "--sensor", "tiny.json", "-o", "pairs"]
    assert cli.main(argv) == 0
    assert "pairs: 2 pairs, 2 of them new" in capsys.readouterr().out
    argv = ["street", "--data", "pairs=1", "--recipe", "tiny", "--work", "work", "-o", "paper.safetensors"]
    assert train.main([*argv, "--steps", "1", "--batch", "1", "--evaluate", "1"]) == 0
    denoiser, card = weight_file.load("paper.safetensors", Denoiser), weight_file.read_card("paper.safetensors")
    assert denoiser.config == recipes.tiny()[-1].denoiser
    assert [stage["step"] for stage in card["stages"]] == [1, 1]
    assert card["data"] == "recordings, tiny"


@pytest.mark.slow
@pytest.mark.skipif(not (DATA / "kitti/object").is_dir(), reason="LIDARDRAFT_DATA holds no objects of KITTI")
def test_real_scans_become_a_training() -> None:
    Path("set").symlink_to(DATA / "kitti/object")
    assert cli.main(["pairs", "--dataset", "kitti", "set", "-o", "pairs"]) == 0
    argv = ["street", "--data", "pairs", "--recipe", "tiny", "--work", "work", "-o", "real.safetensors"]
    assert train.main([*argv, "--steps", "2", "--batch", "1", "--evaluate", "1"]) == 0


def test_a_run_that_is_stopped_goes_on_with_the_same_call(capsys: pytest.CaptureFixture[str]) -> None:
    argv = [*ARGV, *SHORT]
    assert train.main([*argv, "--minutes", "0.0001"]) == 0
    assert "the same call goes on" in capsys.readouterr().out
    assert not Path("tiny.safetensors").exists()
    assert train.main(argv) == 0
    assert Path("tiny.safetensors").exists()


def test_pairs_become_a_segmenter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("lidardraft.cli.command._EVERY", 0.0)  # each step is a line
    sensor = Sensor(name="small", elevations=tuple(np.linspace(0.03, -0.4, 16).tolist()), columns=64)
    road = Primitive(shape="plane", center=(0, 0, 0), size=(60, 60, 0), label="road", id="road")
    image = raycast(Layout(primitives=(road,)), sensor)
    list(write_pairs(tmp_path / "pairs", [(Pair(image, image), {})]))
    argv = ["segmenter", "--pairs", str(tmp_path / "pairs"), "--batch", "1", "-o", str(tmp_path / "run")]
    assert train.main([*argv, "--steps", "2", "--minutes", "1e-9"]) == 0
    assert train.main([*argv, "--steps", "2"]) == 0
    assert "segmenter: 100% 2/2 " in capsys.readouterr().err
    label = weight_file.load(tmp_path / "run" / "weights.safetensors", Segmenter).label(image)
    np.testing.assert_array_equal(label > 0, image.valid)
    assert train.main([*argv, "--steps", "2", "--seed", "1"]) == 2
    assert "another config: its seed is 0, not 1" in capsys.readouterr().err
    pairs, weights = str(tmp_path / "pairs"), str(tmp_path / "run" / "weights.safetensors")
    further = ["segmenter", "--batch", "1", "--steps", "1", "-o", "further", "--pairs"]
    assert train.main([*further, f"{pairs}=3", pairs, "--init", weights]) == 0
    card = weight_file.read_card("further/weights.safetensors")
    assert card["data"].startswith("75% ")
    assert train.main([*further, f"{pairs}=many"]) == 2
    assert "behind = there must be a number" in capsys.readouterr().err


@pytest.mark.parametrize("run", ["m.obj", "m.obj/run"])
def test_a_file_in_the_place_of_the_run_is_refused_before_the_pairs_are_read(
    run: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("m.obj").touch()
    assert train.main(["segmenter", "--pairs", "none", "-o", run]) == 2
    assert capsys.readouterr().err == "lidardraft-train: m.obj is a file; it must be a folder\n"


def test_scores_of_unseen_streets(capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["evaluate", "--weights", "paper-small", "-n", "1", "--sensor", "small.json", "--steps", "2"]
    assert cli.main(argv) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("1 street, small, 2 steps\n")
    names = captured.out.splitlines()[1].split()
    assert names == ["objects", "other", "all", "drop", "range", "height", "BEV", "classes", "holes", "lone"]
    rows = re.findall(r"^(\S.*?)(?: +(?:\d\.\d{3}|nan)){10}$", captured.out, re.MULTILINE)
    assert rows == ["detailed scan", "other streets", "condition image", "simulated", "generated", "untrained"]
    assert len(re.findall(r"^ {4}all, by class: .*road \d\.\d\d", captured.out, re.MULTILINE)) == 6
    assert len(re.findall(r"^ {4}intensity \(JSD\), by class: .*road \d\.\d\d", captured.out, re.MULTILINE)) >= 2
    assert captured.err == (
        "lidardraft: these weights were trained on beams of 64, and small has 16; its scans may be poor\n"
    )
