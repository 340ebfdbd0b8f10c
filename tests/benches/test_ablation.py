"""The arms of the paper's ablation differ in what they say, and nothing else; and their table."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
import torch

import ablation
import published_tables
from ablation import ARMS, loss_by_other_layouts, top_view
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.evaluation import unseen_streets
from lidardraft.networks import weight_file
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME
from lidardraft.training import recipes

BASE, CONTROL = recipes.tiny()
ABLATION = ["--sensor", "small.json", "--base-steps", "1", "--steps", "1", "-n", "1", "--work", "work"]
SENSOR = Sensor(name="small", elevations=tuple(np.linspace(0.05, -0.4, 16).tolist()), columns=128)


def test_the_papers_own_row_is_its_recipe() -> None:
    assert ARMS["paper"].stage(CONTROL) == dataclasses.replace(CONTROL, watch_every=0)


def test_arms_stand_on_the_papers_base_and_learn_as_long() -> None:
    base = Denoiser.from_config(BASE.denoiser)
    for arm in ARMS.values():
        stage = arm.stage(CONTROL)
        assert stage.steps == CONTROL.steps
        begun = base.with_controlnet(stage.denoiser) if arm.controlnet else base.with_condition(stage.denoiser)
        assert (begun.controlnet is not None) == arm.controlnet


def test_each_arm_changes_one_part() -> None:
    paper = ARMS["paper"]
    for name, arm in ARMS.items():
        changed = [f.name for f in dataclasses.fields(arm) if getattr(arm, f.name) != getattr(paper, f.name)]
        assert len(changed) == (name != "paper"), name


def test_without_tuning_the_zero_convolutions_learn_alone_to_the_end() -> None:
    stage = ARMS["ControlNet not fine-tuned"].stage(CONTROL)
    assert stage.zero_conv_steps == stage.steps
    assert ARMS["semantic map alone"].stage(CONTROL).denoiser.condition == ("class",)
    assert ARMS["without classes"].stage(CONTROL).denoiser.condition == ("depth",)


ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road")
TOWER = Primitive(shape="box", center=(12, 0, 20), size=(6, 6, 40), label="building", id="tower")
CAR = Primitive(shape="box", center=(0, 8, 0.75), size=(2, 4, 1.5), label="car", id="car", instance=1)


def test_a_pixel_is_the_surface_below_its_place() -> None:
    image = top_view(Layout(primitives=(ROAD, TOWER, CAR)), SENSOR, SENSOR.pose())
    distance = np.geomspace(ablation.FAR, ablation.NEAR, 16)
    azimuth = SENSOR.azimuth_start - (np.arange(128) + 0.5) * SENSOR.azimuth_span / 128
    x, y = distance[:, None] * np.cos(azimuth), distance[:, None] * np.sin(azimuth)
    expected = np.full(SENSOR.shape, BY_NAME["road"].id)
    expected[(abs(x - 12) < 3) & (abs(y) < 3)] = BY_NAME["building"].id
    expected[(abs(x) < 1) & (abs(y - 8) < 2)] = BY_NAME["car"].id
    assert len(np.unique(expected)) == 3
    np.testing.assert_array_equal(image.label, expected)
    depths = {name: np.unique(image.depth[image.label == BY_NAME[name].id]) for name in ("road", "car", "building")}
    assert depths["road"] == pytest.approx([12 + SENSOR.mount_height], abs=1e-3)
    assert depths["car"] == pytest.approx([12 + SENSOR.mount_height - 1.5], abs=1e-3)
    assert depths["building"] == pytest.approx([0.1])  # higher than the ceiling


def test_the_view_turns_and_moves_with_the_sensor() -> None:
    layout = Layout(primitives=(ROAD, CAR))
    here = top_view(layout, SENSOR, SENSOR.pose())
    turned = top_view(layout, SENSOR, SENSOR.pose(yaw=np.pi / 2))
    # to the left of a sensor that looks along x is ahead of one that looks along y
    np.testing.assert_array_equal(np.roll(here.label, 32, axis=1), turned.label)
    away = dataclasses.replace(CAR, center=(50, 8, 0.75))
    moved = top_view(Layout(primitives=(ROAD, away)), SENSOR, SENSOR.pose(x=50))
    np.testing.assert_array_equal(moved.label, here.label)


def test_a_network_that_does_not_heed_its_layout_does_as_well_by_another() -> None:
    torch.manual_seed(0)
    pairs = unseen_streets(2, sensor=SENSOR)
    papers = Denoiser.from_config(BASE.denoiser).with_controlnet(CONTROL.denoiser)
    scans, images = [pair.scan for pair in pairs], [pair.condition_image for pair in pairs]
    assert loss_by_other_layouts(papers, scans, images) == 1.0  # its zero convolutions are zero
    torch.nn.init.normal_(papers.network.head.weight, std=0.05)
    assert papers.controlnet is not None
    for _, conv in papers.controlnet.zero_convs():
        torch.nn.init.normal_(conv.weight, std=0.05)
    assert loss_by_other_layouts(papers, scans, images) != 1.0


@pytest.mark.slow
def test_the_table_has_a_row_for_each_arm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny = recipes.tiny()
    monkeypatch.chdir(tmp_path)
    SENSOR.save("small.json")
    monkeypatch.setattr(recipes, "paper_small", lambda: tiny)
    for alike in ("ControlNet not fine-tuned", "without classes", "semantic map alone"):
        monkeypatch.delitem(ARMS, alike)  # they differ in their configs alone
    ablation.main(ABLATION)
    shown = capsys.readouterr().out
    assert shown.startswith("1 street, small; base 1 steps, each arm 1 steps\n")
    number = r" +(?:\d+\.\d{3}|nan)"
    rows = re.findall(rf"^(\S.*?){number}{number} +\d\.\d{{3}} +\d+\.\d{{3}} +\d\.\d{{3}}$", shown, re.MULTILINE)
    assert rows == ["other streets", "cast passed through", "untrained", "no condition", *ARMS]
    argv = ["--real", "work/scans/other-streets", "--generated"]
    argv += ["full=work/scans/paper", "bird-eye=work/scans/top-view-not-cast", "mine=work/scans/paper"]
    published_tables.main(argv)
    told = capsys.readouterr().out
    assert told.count("these 1 scans") == 3
    assert "Table 2" in told
    assert "LiDARDraft (published)" in told
    assert "mine\n  these 1 scans" in told.split("Not in the paper")[1]
    base = weight_file.load("work/base/weights.safetensors", Denoiser)
    steps = {}
    for weights in Path("work").glob("*/weights.safetensors"):
        arm = weight_file.load(weights, Denoiser)
        steps[weights.parent.name] = weight_file.read_card(weights)["step"]
        if arm.controlnet is not None:
            pairs = zip(arm.network.parameters(), base.network.parameters(), strict=True)
            assert all(torch.equal(one, other) for one, other in pairs)
    assert steps == dict.fromkeys(steps, 1)
    assert len(steps) == len(ARMS) + 1  # and the base
    assert weight_file.read_card("work/top-view-not-cast/weights.safetensors")["data"].endswith("from above")
    ablation.main([*ABLATION, "--base", "work/base/weights.safetensors"])  # all of it is there already
    assert capsys.readouterr().out.splitlines()[1:] == shown.splitlines()[1:]
