import dataclasses
import itertools
import json
import os
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from box_pairs import SENSOR, make_pair, noted

from lidardraft.diffusion.codec import MAX_DEPTH, decode_scan, encode_scan
from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.formats import pairs as module
from lidardraft.formats.pairs import is_shard, pairs_on_disk, read_shard, write_pairs
from lidardraft.scene.sensor import Sensor
from lidardraft.training.sources import PairFolder, scans_of_step


@pytest.fixture(autouse=True)
def short_shards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SHARD", 2)


def test_pairs_come_back(tmp_path: Path) -> None:
    assert list(write_pairs(tmp_path, (noted(seed) for seed in range(5)))) == [2, 4, 5]
    folder = PairFolder(tmp_path)
    assert len(folder) == 5
    assert folder.sensor == SENSOR
    assert folder.notes == [{"seed": seed} for seed in range(5)]
    for seed in range(5):
        pair, found_pair = make_pair(seed), folder[seed]
        for found, image in zip(found_pair, pair, strict=True):
            np.testing.assert_allclose(found.depth, image.depth, atol=0.0011)
            np.testing.assert_array_equal(found.valid, image.valid)
        assert found_pair.scan.intensity is not None
        np.testing.assert_allclose(found_pair.scan.intensity, pair.scan.intensity, atol=1 / 500)
        for name in ("scan", "condition_image"):
            np.testing.assert_array_equal(getattr(found_pair, name).label, getattr(pair, name).label)


def test_an_interrupted_folder_goes_on_where_it_stopped(tmp_path: Path) -> None:
    assert pairs_on_disk(tmp_path) == 0

    def breaking() -> "itertools.chain[module.NotedPair]":
        yield from (noted(seed) for seed in range(3))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list(write_pairs(tmp_path, breaking()))
    assert pairs_on_disk(tmp_path) == 2
    list(write_pairs(tmp_path, (noted(seed) for seed in range(pairs_on_disk(tmp_path), 5))))
    folder = PairFolder(tmp_path)
    assert len(folder) == 5
    for seed in range(5):
        np.testing.assert_array_equal(folder[seed].scan.label, make_pair(seed).scan.label)
    assert not list(tmp_path.glob("*.partial"))


def test_what_is_no_shard_of_the_folder_is_refused(tmp_path: Path) -> None:
    list(write_pairs(tmp_path, [noted(0)]))
    make_pair(0).scan.save(tmp_path / "scan.npz")
    assert [is_shard(tmp_path / name) for name in ("00000.npz", "scan.npz")] == [True, False]
    for name in ("index.json", "none.npz"):
        with pytest.raises(FormatError, match=name):
            is_shard(tmp_path / name)
    (tmp_path / "copy.npz").write_bytes((tmp_path / "00000.npz").read_bytes())
    with pytest.raises(FormatError, match=r"copy.npz is not in the index.json beside it"):
        read_shard(tmp_path / "copy.npz")
    (tmp_path / "index.json").unlink()
    with pytest.raises(FormatError, match=r"index.json: No such file"):
        read_shard(tmp_path / "00000.npz")


def test_a_folder_has_one_writer_at_a_time(tmp_path: Path) -> None:
    first = write_pairs(tmp_path, (noted(seed) for seed in range(4)))
    assert next(first) == 2
    with pytest.raises(FormatError, match=f"is being written by process {os.getpid()} on "):
        next(write_pairs(tmp_path, [noted(4)]))
    first.close()
    assert list(write_pairs(tmp_path, [noted(2)])) == [3]


def test_pairs_of_another_writer_are_noticed(tmp_path: Path) -> None:
    start = pairs_on_disk(tmp_path)
    list(write_pairs(tmp_path, [noted(0)]))
    with pytest.raises(FormatError, match="holds 1 pairs, no longer 0: another process"):
        list(write_pairs(tmp_path, [noted(0)], start=start))
    assert pairs_on_disk(tmp_path) == 1


def test_what_a_killed_writer_left_is_cleared(tmp_path: Path) -> None:
    list(write_pairs(tmp_path, [noted(0)]))
    (tmp_path / "00001.npz.1234.partial").write_bytes(b"half")
    list(write_pairs(tmp_path, [noted(1)]))
    assert sorted(file.name for file in tmp_path.iterdir()) == ["00000.npz", "00001.npz", "index.json"]


def test_a_scan_without_intensities_has_zeros(tmp_path: Path) -> None:
    pair = make_pair(0)
    bare = pair._replace(scan=dataclasses.replace(pair.scan, intensity=None))
    list(write_pairs(tmp_path, [(bare, {})]))
    intensity = PairFolder(tmp_path)[0].scan.intensity
    assert intensity is not None
    assert not intensity.any()


def test_a_depth_that_does_not_fit_is_the_furthest_that_does(tmp_path: Path) -> None:
    far = Sensor(name="far", elevations=SENSOR.elevations, columns=128, max_range=300.0)
    pair = make_pair(0, far)
    depth = pair.scan.depth.copy()
    depth[0, 0] = 200.0
    list(write_pairs(tmp_path, [(pair._replace(scan=dataclasses.replace(pair.scan, depth=depth)), {})]))
    assert PairFolder(tmp_path)[0].scan.depth[0, 0] == pytest.approx(131.07)
    state = encode_scan(PairFolder(tmp_path)[0].scan)
    assert decode_scan(state, far).depth[0, 0] == pytest.approx(MAX_DEPTH)


def test_a_return_nearer_than_a_step_stays_a_return(tmp_path: Path) -> None:
    near = Sensor(name="near", elevations=SENSOR.elevations, columns=128, min_range=0.0)
    pair = make_pair(0, near)
    depth = pair.scan.depth.copy()
    depth[0, 0] = 1e-4
    list(write_pairs(tmp_path, [(pair._replace(scan=dataclasses.replace(pair.scan, depth=depth)), {})]))
    assert PairFolder(tmp_path)[0].scan.valid[0, 0]


def test_a_shard_of_another_shape_is_refused(tmp_path: Path) -> None:
    list(write_pairs(tmp_path, [noted(0), noted(1)]))
    with np.load(tmp_path / "00000.npz") as file:
        images = {name: file[name] for name in module.IMAGES}
    images["scan_label"] = images["scan_label"][:1]
    module._write(tmp_path / "00000.npz", images, [{}, {}])
    with pytest.raises(FormatError, match=r"scan_label is uint8 \(1, 16, 128\); it must be uint8 \(2, 16, 128\)"):
        PairFolder(tmp_path)


@pytest.mark.parametrize(
    ("name", "damage", "message"),
    [
        ("00000.npz", lambda _: b"", "not a whole .npz file"),
        ("00000.npz", lambda data: data[: len(data) // 2], "not a whole .npz file"),
        (
            "00000.npz",
            lambda data: data[:5000] + bytes([data[5000] ^ 255]) + data[5001:],
            "not a whole .npy file: Bad CRC",
        ),
        ("00000.npz", None, "No such file"),
        ("index.json", None, "No such file"),
        ("index.json", lambda _: b"{", "not JSON"),
        ("index.json", lambda _: b"[]", r"\[\] is not a JSON object"),
    ],
)
def test_a_damaged_file_is_refused(
    tmp_path: Path, name: str, damage: Callable[[bytes], bytes] | None, message: str
) -> None:
    list(write_pairs(tmp_path, [noted(0), noted(1)]))
    file = tmp_path / name
    if damage is None:
        file.unlink()
    else:
        file.write_bytes(damage(file.read_bytes()))
    with pytest.raises(FormatError, match=f"{name}: .*{message}"):
        PairFolder(tmp_path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema": "other"}, "schema is 'other'; this version reads 'lidardraft.pairs/5'"),
        ({"classes": ["hedge"]}, r"index\.json: the pairs have another class table"),
        ({"shards": ["a"]}, "shards is .* it must be counts of 1 to"),
        ({"shards": [10**12]}, "shards is .* it must be counts"),
        ({"shards": [2**16] * 2**12}, r"with its 268435456 pairs needs \d+\.\d GB of memory"),
        ({"sensor": {}}, "index.json: 'columns' is missing"),
    ],
)
def test_an_index_of_other_values_is_refused(tmp_path: Path, change: dict[str, object], message: str) -> None:
    list(write_pairs(tmp_path, [noted(0)]))
    index = json.loads((tmp_path / "index.json").read_text())
    (tmp_path / "index.json").write_text(json.dumps(index | change))
    with pytest.raises(LidarDraftError, match=message):
        PairFolder(tmp_path)


@pytest.mark.parametrize(
    ("notes", "message"),
    [
        ("[{}, ", r"00000\.npz: notes\.json: not JSON: "),
        ("{}", r"00000\.npz: notes\.json: \{\} is not a JSON list"),
        ("[{}, 2]", r"00000\.npz: notes\.json: 2 is not a JSON object"),
        ("[" * 1_000_000, r"00000\.npz: notes\.json: not JSON that can be read"),
    ],
)
def test_notes_that_are_no_list_of_objects_are_refused(tmp_path: Path, notes: str, message: str) -> None:
    list(write_pairs(tmp_path, [noted(0), noted(1)]))
    shard = tmp_path / "00000.npz"
    with zipfile.ZipFile(shard) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(shard, "w") as archive:
        for name, data in (content | {"notes.json": notes.encode()}).items():
            archive.writestr(name, data)
    with pytest.raises(FormatError, match=message):
        PairFolder(tmp_path)


def test_pairs_of_a_step_are_the_same_each_time(tmp_path: Path) -> None:
    list(write_pairs(tmp_path, (noted(seed) for seed in range(3))))
    folder = PairFolder(tmp_path)
    first, again, other = (folder.stack(step, 8).images["scan_depth"] for step in (4, 4, 5))
    assert first.shape == (8, *SENSOR.shape)
    assert torch.equal(first, again)
    assert not torch.equal(first, other)
    whole = np.stack([folder[number].compact()["scan_depth"] for number in range(3)])
    for rows in first.numpy().view(np.uint16):  # each is one of the folder's, to the bit
        assert (rows == whole).all(axis=(1, 2)).sum() == 1


def test_a_step_has_room_for_fewer_large_scans() -> None:
    assert scans_of_step(4, SENSOR) == 4
    for columns, scans in ((1024, 4), (2048, 2), (65536, 1)):
        assert scans_of_step(4, Sensor(name="s", elevations=tuple(-0.006 * np.arange(64)), columns=columns)) == scans
