"""The comparison with other casters: its scenes, its peers, its processes, its table."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from compare import COLUMNS, Results, agreement, markdown
from peers import PEERS, LidarDraft
from scenes import Pattern, Scene, column_poses, hdl64, pose, poses, small

COMPARE = Path(__file__).parents[2] / "benches" / "compare.py"


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(COMPARE), "--scenes", "small", "--rounds", "1", "--batch", "2", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_one_table_and_a_line_for_who_is_not_there(tmp_path: Path) -> None:
    result = run("--threads", "1", "--peers", "analytic,triangles,nobody", "--json", str(tmp_path / "rounds.json"))
    assert result.returncode == 0, result.stderr
    assert "without nobody on 1 threads" in result.stderr
    rows = [line.split(" | ") for line in result.stdout.splitlines() if line.startswith("| small")]
    measured = [row[1] for row in rows]
    assert measured[:4] == ["build from arrays", "compile a layout", "bare cast", "end to end, `out=`"]
    assert measured[4:] == ["end to end, new arrays", "a pose for each column", "batch, one scan of it"]
    assert all(float(cell) > 0 for row in rows for cell in row[6:8])  # ours, analytic and triangles
    assert rows[2][12] == "100.000%, 100.000%"  # as the reference path
    assert "scans/s" in result.stdout
    rounds = json.loads((tmp_path / "rounds.json").read_text())
    assert ["small", "triangles", 1, "cast"] in [entry[:4] for entry in rounds["seconds"]]


def test_agreement_counts_ranges_within_tolerance_and_instances() -> None:
    depth = np.array([[10.0, 10.0, 0.0, 100.0]])
    label = np.zeros((1, 4), np.uint8)
    expected = depth, label, np.array([[1, 2, -1, 4]])
    got = depth + np.array([0.0019, 0.0022, 1.0, 0.0029]), label, np.array([[1, 2, 7, 4]])
    assert agreement(expected, got) == (0.5, 0.75)


def test_rows_hold_medians_and_ratios() -> None:
    results = Results()
    for milliseconds in (2.0, 90.0, 1.0):  # one round was disturbed
        results.add("small", "open3d", 1, "cast", 10e-3 * milliseconds)
        results.add("small", "packets", 1, "cast", 4e-3 * milliseconds)
        results.add("small", "analytic", 1, "cast", 0.1e-3 * milliseconds)
    results.agreement["small", "analytic"] = (1.0, 0.99998)
    head, _, *rows = markdown(results, ["small", "street"], [1, 2]).splitlines()
    assert [cell.strip() for cell in head.split("|")[1:-1]] == list(COLUMNS)
    assert len(rows) == 1
    row = dict(zip(COLUMNS, (cell.strip() for cell in rows[0].split("|")[1:-1]), strict=True))
    assert row["measured"] == "bare cast"
    assert (row["Open3D"], row["packet Embree"], row["analytic"], row["triangles"]) == ("20.0", "8.00", "0.200", "")
    assert (row["analytic / Open3D"], row["analytic / packets"], row["triangles / Open3D"]) == ("100x", "40.0x", "")
    assert row["same analytic"] == "100.000%, 99.998%"


SCENE = small()
PATTERN = hdl64(beams=8, columns=64)


def ready(name: str, scene: Scene = SCENE, pattern: Pattern = PATTERN) -> LidarDraft:
    peer: LidarDraft = PEERS[name](1)
    peer.build(scene)
    peer.prepare(pattern)
    return peer


@pytest.mark.parametrize("name", ["analytic", "triangles", "fresh"])
def test_our_caster_as_a_peer(name: str) -> None:
    peer = ready(name)
    depth, semantic, instance = (image.copy() for image in peer.scan(pose(2)))
    assert (depth.dtype, semantic.dtype, instance.dtype) == (np.float32, np.uint8, np.int32)
    assert depth.shape == semantic.shape == instance.shape == PATTERN.shape
    miss = depth == 0
    assert 0 < miss.mean() < 0.5  # some rays look up
    assert (instance[miss] == -1).all()
    assert (semantic[miss] == 0).all()
    assert set(instance[~miss]) > {0}  # the ground, and boxes
    assert all(semantic[instance == body.instance].tolist() == [body.semantic] * (instance == body.instance).sum()
               for body in SCENE.primitives)  # fmt: skip
    near, same = agreement(peer.reference(pose(2)), (depth, semantic, instance))
    assert (near, same) == (1.0, 1.0)
    cast = peer.cast(pose(2))
    np.testing.assert_array_equal(cast["depth"][0], depth)
    np.testing.assert_array_equal(cast["label"][0], semantic)
    np.testing.assert_array_equal(cast["instance"][0], np.maximum(instance, 0))


def test_boxes_are_the_same_as_their_triangles() -> None:
    analytic, triangles = ready("analytic"), ready("triangles")
    for step in range(4):
        near, same = agreement(analytic.scan(pose(step)), triangles.scan(pose(step)))
        assert near >= 0.999
        assert same >= 0.999


def test_a_batch_and_a_rolling_shutter_are_scans() -> None:
    peer = ready("analytic")
    batch = peer.batch(poses(3, 2))
    assert peer.batch(poses(3, 2)) is batch
    np.testing.assert_array_equal(batch.depth[1], peer.scan(pose(4))[0])
    still = np.repeat(pose(4)[None], PATTERN.shape[1], axis=0)
    np.testing.assert_allclose(peer.rolling(still).depth, batch.depth[1], rtol=1e-5, atol=2e-3)
    moving = peer.rolling(column_poses(4, PATTERN.shape[1])).depth.copy()
    column = peer.scan(column_poses(4, PATTERN.shape[1])[-1])[0][:, -1]
    np.testing.assert_allclose(moving[:, -1], column, rtol=1e-5, atol=2e-3)
    assert np.abs(moving - batch.depth[1]).max() > 0.01


@pytest.mark.parametrize("threads", [1, 2])
def test_embree_in_packets_hits_the_same(threads: int) -> None:
    try:
        peer = PEERS["packets"](threads)
    except RuntimeError as missing:
        pytest.skip(str(missing))
    peer.build(SCENE)
    peer.prepare(PATTERN)
    ours = ready("triangles")
    assert agreement(ours.scan(pose(0)), peer.images(pose(0))) == (1.0, 1.0)
    # Casting twice without aiming finds the same hits: the rays have only become shorter.
    peer.cast(pose(0))
    with pytest.raises(RuntimeError, match="no packets"):
        peer.prepare(hdl64(beams=1, columns=7))
