"""Our peers return what the benchmarks ask for, and Embree in packets the same."""

import numpy as np
import pytest

import peer_analytic
import peer_fresh
import peer_triangles
from compare_table import agreement
from peer_lidardraft import Peer
from scenes import Pattern, Scene, column_poses, hdl64, pose, poses, small

SCENE = small()
PATTERN = hdl64(beams=8, columns=64)


def ready(peer: Peer, scene: Scene = SCENE, pattern: Pattern = PATTERN) -> Peer:
    peer.build(scene)
    peer.prepare(pattern)
    return peer


@pytest.mark.parametrize("module", [peer_analytic, peer_triangles, peer_fresh])
def test_the_hook(module: type[peer_analytic]) -> None:
    peer = ready(module.bench_peer(1))
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
    analytic, triangles = ready(peer_analytic.bench_peer(1)), ready(peer_triangles.bench_peer(1))
    for step in range(4):
        near, same = agreement(analytic.scan(pose(step)), triangles.scan(pose(step)))
        assert near >= 0.999
        assert same >= 0.999


def test_arrays_stay_unless_the_peer_is_fresh() -> None:
    kept, fresh = ready(peer_analytic.bench_peer(1)), ready(peer_fresh.bench_peer(1))
    assert kept.scan(pose(0))[0] is kept.scan(pose(1))[0]
    first, second = fresh.scan(pose(0))[0], fresh.scan(pose(1))[0]
    assert not np.shares_memory(first, second)
    assert not np.array_equal(first, second)
    assert not np.shares_memory(kept.scan_fresh(pose(0)).depth, kept.scan_fresh(pose(1)).depth)


def test_a_batch_and_a_rolling_shutter_are_scans() -> None:
    peer = ready(peer_analytic.bench_peer(1))
    batch = peer.batch(poses(3, 2))
    assert peer.batch(poses(3, 2)) is batch
    np.testing.assert_array_equal(batch.depth[1], peer.scan(pose(4))[0])
    still = np.repeat(pose(4)[None], PATTERN.shape[1], axis=0)
    np.testing.assert_allclose(peer.rolling(still).depth, batch.depth[1], rtol=1e-5, atol=2e-3)
    moving = peer.rolling(column_poses(4, PATTERN.shape[1])).depth.copy()
    column = peer.scan(column_poses(4, PATTERN.shape[1])[-1])[0][:, -1]
    np.testing.assert_allclose(moving[:, -1], column, rtol=1e-5, atol=2e-3)
    assert np.abs(moving - batch.depth[1]).max() > 0.01


def test_instances_that_are_no_indices_are_refused() -> None:
    with pytest.raises(AssertionError, match="instance"):
        Peer(1, triangles=False).build(Scene("turned", SCENE.primitives[::-1]))


@pytest.mark.parametrize("threads", [1, 2])
def test_embree_in_packets_hits_the_same(threads: int) -> None:
    packets = pytest.importorskip("peer_packets")
    try:
        peer = packets.bench_peer(threads)
    except RuntimeError as missing:
        pytest.skip(str(missing))
    peer.build(SCENE)
    peer.prepare(PATTERN)
    ours = ready(peer_triangles.bench_peer(1))
    assert agreement(ours.scan(pose(0)), peer.images(pose(0))) == (1.0, 1.0)
    # Casting twice without aiming finds the same hits: the rays have only become shorter.
    peer.cast(pose(0))
    with pytest.raises(RuntimeError, match="no packets"):
        peer.prepare(hdl64(beams=1, columns=7))
