"""Published protocols, beside slow implementations written from their definitions, and the networks they ask."""

import dataclasses
import math
import random
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.linalg import sqrtm
from scipy.spatial.distance import cdist, jensenshannon

from lidardraft.errors import LidarDraftError
from lidardraft.formats.kitti import write_bin
from lidardraft.metrics import comparisons
from lidardraft.metrics.spherical import SphericalImage, corner_points, spherical_image
from lidardraft.perception.feature_networks import NETWORKS, FeatureNetwork
from lidardraft.protocols import PROTOCOLS, Score, _first, _sides, compare

POINTS = 400
Scans = list[np.ndarray]


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that a few scans are compared in several blocks."""
    monkeypatch.setattr(comparisons, "_BLOCK", 3)


def scans_of(seed: int, count: int, spread: float) -> Scans:
    """Points of a wide street, some of them too near, too far, above the field of view or outside LiDM's square."""
    drawn = np.random.default_rng(seed)
    scale = np.array([spread, 0.6 * spread, 1.5])
    return [(drawn.normal(0, 1, (POINTS, 3)) * scale - [0, 0, 1]).astype(np.float32) for _ in range(count)]


def files_of(folder: Path, scans: Scans) -> list[Path]:
    folder.mkdir()
    files = [folder / f"{number:06d}.bin" for number in range(len(scans))]
    for file, points in zip(files, scans, strict=True):
        write_bin(file, points, np.full(len(points), 0.25, dtype=np.float32))
    return files


@pytest.fixture
def sets(tmp_path: Path) -> tuple[Scans, Scans, list[Path], list[Path]]:
    recorded, generated = scans_of(1, 9, 22), scans_of(2, 5, 30)
    return recorded, generated, files_of(tmp_path / "real", recorded), files_of(tmp_path / "made", generated)


def scored(name: str, real: list[Path], made: list[Path], **more: object) -> dict[str, Score]:
    return {score.metric: score for score in compare(PROTOCOLS[name], real, made, **more)}  # type: ignore[arg-type]


def slow_pixels(points: np.ndarray, near: float, far: float) -> dict[tuple[int, int], np.ndarray]:
    """The nearest point of each pixel, one point after the other."""
    nearest: dict[tuple[int, int], np.ndarray] = {}
    for point in points.astype(float):
        distance = math.dist(point, (0, 0, 0))
        if near < distance < far:
            across = 0.5 * (1 - math.atan2(point[1], point[0]) / math.pi)
            down = 1 - (math.degrees(math.asin(point[2] / distance)) + 25) / 28
            pixel = min(max(math.floor(64 * down), 0), 63), min(max(math.floor(1024 * across), 0), 1023)
            if pixel not in nearest or distance < math.dist(nearest[pixel], (0, 0, 0)):
                nearest[pixel] = point
    return nearest


def slow_corners(pixels: dict[tuple[int, int], np.ndarray], clip: float = math.inf) -> np.ndarray:
    found = []
    for (row, column), point in pixels.items():
        distance = min(float(np.float32(np.linalg.norm(point))), clip)
        pitch, yaw = math.radians(3 - 28 * row / 64), math.pi * (2 * column / 1024 - 1)
        flat = distance * math.cos(pitch)
        found.append((flat * math.cos(yaw), -flat * math.sin(yaw), distance * math.sin(pitch)))
    return np.array(found)


def test_the_projection_keeps_the_nearest_and_clamps_rows() -> None:
    (points,) = scans_of(3, 1, 20)
    points = np.concatenate([points, [[5, 0, 5], [10, 0, 10], [4, 0, -9], [2, 0.001, 0], [-3, 1e-9, 0]]]).astype("f4")
    image = spherical_image(points, near=1.0, far=56.0)
    expected = slow_pixels(points, 1.0, 56.0)
    assert {tuple(pixel) for pixel in np.argwhere(image.depth > 0)} == expected.keys()
    for pixel, point in expected.items():
        np.testing.assert_allclose(image.points[pixel], point, rtol=1e-6)
        assert image.depth[pixel] == pytest.approx(np.linalg.norm(point))
    assert image.depth[0, 512] == pytest.approx(math.sqrt(50))  # over +3 degrees: the first row, the nearer of two
    corners = corner_points(image.depth)[image.depth > 0]
    np.testing.assert_allclose(sorted(map(tuple, corners)), sorted(map(tuple, slow_corners(expected))), atol=1e-5)


def slow_cells(points: np.ndarray, edge: float) -> set[tuple[int, int]]:
    inside = [p for p in points if abs(p[0]) < 50 and abs(p[1]) < 50]
    return {(math.floor(x / edge) + round(50 / edge), math.floor(y / edge) + round(50 / edge)) for x, y, _ in inside}


def test_lidm(sets: tuple[Scans, Scans, list[Path], list[Path]]) -> None:
    recorded, generated, *files = sets
    real, made = ([slow_corners(slow_pixels(p, 1, 56)) for p in scans] for scans in (recorded, generated))
    scores = scored("lidm", *files)
    sums = []
    for scans in (real, made):
        sums.append(np.zeros((2000, 2000)))
        for points in scans:
            for cell in slow_cells(points, 0.05):
                sums[-1][cell] += 1
    assert scores["JSD"].value == pytest.approx(jensenshannon(*(total.ravel() for total in sums)))
    views = [[np.array(sorted(slow_cells(points, 0.5))) / 200 for points in scans] for scans in (real, made)]
    total = 0.0
    for view in views[0]:
        squares = [cdist(view, other, "sqeuclidean") for other in views[1]]
        total += min((square.min(axis=1).mean() + square.min(axis=0).mean()) / 2 for square in squares)
    assert scores["MMD"].value == pytest.approx(total / len(real), rel=1e-5)
    assert scores["MMD"].recorded, scores["MMD"].generated == (9, 5)
    assert "rangenet21_lidm/backbone" in scores["FRID"].left_out


def slow_mmd(real: Scans, made: Scans, norm: Callable[[np.ndarray], float]) -> float:
    def kernel(some: Scans, others: Scans) -> float:
        values = [math.exp(-(norm(a / a.sum() - b / b.sum()) ** 2) / (2 * 0.5**2)) for a in some for b in others]
        return sum(values) / len(values)

    return kernel(real, real) + kernel(made, made) - 2 * kernel(real, made)


def slow_histogram(points: np.ndarray) -> np.ndarray:
    counts = np.zeros((100, 100))
    for x, y, z in points:
        if 3 < math.hypot(x, y, z) < 70 and abs(x) < 80 and abs(y) < 80:
            counts[math.floor((x + 80) / 1.6), math.floor((y + 80) / 1.6)] += 1
    return counts


def test_r2dm(sets: tuple[Scans, Scans, list[Path], list[Path]]) -> None:
    *scans, real, made = sets
    kept = [[[p for p in slow_pixels(x, 0, math.inf).values() if 0.5 < math.dist(p, (0, 0, 0)) < 63] for x in some]
            for some in scans]  # fmt: skip
    counts = [[slow_histogram(np.array(points)) for points in some] for some in kept]
    scores = scored("r2dm", real, made)
    assert scores["JSD"].value == pytest.approx(jensenshannon(*(sum(some).ravel() for some in counts)))
    assert scores["MMD"].value == pytest.approx(slow_mmd(*counts, lambda d: float(np.sqrt((d**2).sum()))), rel=1e-5)
    assert [name for name, score in scores.items() if score.left_out] == ["FRD", "FPD"]


def test_lidargen_takes_as_many_recorded_scans_and_the_matrix_norm(
    sets: tuple[Scans, Scans, list[Path], list[Path]],
) -> None:
    recorded, generated, real, made = sets
    scores = scored("lidargen", real[:5], made)
    counts = [[slow_histogram(slow_corners(slow_pixels(p, 0, math.inf), 63)) for p in some]
              for some in (recorded[:5], generated)]  # fmt: skip
    norm = slow_mmd(*counts, lambda d: float(np.linalg.svd(d, compute_uv=False)[0]))
    assert scores["MMD"].value == pytest.approx(norm, rel=1e-5)
    assert scores["JSD"].value == pytest.approx(jensenshannon(*(sum(some).ravel() for some in counts)))
    assert scored("lidargen", real, made)["MMD"].recorded == 5


def test_the_floor_is_that_of_halves_of_the_recorded_scans(tmp_path: Path) -> None:
    real, made = files_of(tmp_path / "real", scans_of(1, 8, 22)), files_of(tmp_path / "made", scans_of(2, 4, 8))
    for name in PROTOCOLS:
        scores = [score for score in scored(name, real, made).values() if not score.left_out]
        assert {len(score.floor) for score in scores} == {10}
        assert {score.floor_scans for score in scores} == {min(scores[0].recorded // 2, 4)}
        assert all(0 < min(score.floor) < max(score.floor) for score in scores)
        assert all(abs(floor) < 1e-6 for s in scored(name, real[:1] * 4, made).values() for floor in s.floor)
    matching = scored("lidm", real, made)["MMD"]
    assert max(matching.floor) < matching.value
    assert scored("lidm", real, real)["MMD"].value == 0  # each finds itself
    assert scored("lidm", real[:1], made)["JSD"].floor == ()


@pytest.mark.parametrize(
    ("recorded", "generated", "half"),
    [(9, 3, 3), (9, 4, 4), (9, 5, 4), (8, 20, 4), (2, 5, 1), (1, 5, 0)],  # min(recorded // 2, generated)
)
def test_halves_are_no_larger_than_the_generated_set(recorded: int, generated: int, half: int) -> None:
    sides, counted = _sides(recorded, generated, np.random.default_rng(0))
    assert counted == half
    assert sides[0].tolist() == [0] * recorded + [1] * generated
    assert len(sides) == (11 if half > 1 else 1)
    for halving in sides[1:]:
        assert [(halving[:recorded] == side).sum() for side in (0, 1)] == [half, half]
        assert (halving[recorded:] == -1).all()  # no generated scan


def test_frd_of_lidargen_takes_the_first_1100_scans() -> None:
    sides = np.stack([np.repeat([0, 1, -1], [1200, 1100, 5]), np.tile([1, 0, -1, -1, -1], 461)]).astype(np.int8)
    limited = _first(sides, 1100)
    assert [(row == side).sum() for row in limited for side in (0, 1)] == [1100, 1100, 461, 461]
    assert (limited[0][:1100] == 0).all()
    assert (limited[1] == sides[1]).all()


def test_a_set_without_a_score(tmp_path: Path, sets: tuple[Scans, Scans, list[Path], list[Path]]) -> None:
    real = sets[2]
    with pytest.raises(LidarDraftError, match="a set of scans is empty"):
        scored("lidm", real, [])
    (lonely,) = files_of(tmp_path / "near", [np.full((3, 3), 0.4, dtype=np.float32)])
    for name in PROTOCOLS:
        with pytest.raises(LidarDraftError, match=r"near/000000.bin: no point lies in the top view"):
            scored(name, real, [lonely])


def test_frechet_distance_agrees_with_the_root_of_a_matrix() -> None:
    drawn = np.random.default_rng(0)
    for recorded, generated in ((40, 30), (6, 5), (40, 5)):  # more and fewer scans than features
        first, second = drawn.normal(0, 1, (recorded, 12)), drawn.normal(0.3, 2, (generated, 12))
        distance = comparisons.FrechetDistance(np.repeat([0, 1], [recorded, generated])[None])
        for features in (*first, *second):
            distance.add(features)
        covariances = [np.cov(x, rowvar=False) for x in (first, second)]
        expected = ((first.mean(axis=0) - second.mean(axis=0)) ** 2).sum() + np.trace(covariances[0] + covariances[1])
        expected -= 2 * np.trace(sqrtm(covariances[0] @ covariances[1])).real
        assert distance.distances()[0] == pytest.approx(expected, rel=1e-4)


def written(network: FeatureNetwork, folder: Path, *, learned: bool = True) -> list[dict[str, torch.Tensor]]:
    """Weights of the public form, as if learned; the published files themselves are not here."""
    torch.manual_seed(0)
    found = []
    for path, part in zip(network.files.split(" and "), network.parts(), strict=True):
        for module in part.modules():
            if learned and isinstance(module, torch.nn.BatchNorm1d | torch.nn.BatchNorm2d):
                module.running_mean.uniform_(-0.1, 0.1)
                module.running_var.uniform_(0.5, 1.5)
        (folder / path).parent.mkdir(exist_ok=True, parents=True)
        found.append(part.state_dict())
        torch.save(found[-1], folder / path)
    return found


@pytest.fixture
def image() -> SphericalImage:
    (points,) = scans_of(4, 1, 20)
    return spherical_image(points, np.full(len(points), 0.5, dtype=np.float32))


def test_pointnet_is_what_its_tensors_say(tmp_path: Path, image: SphericalImage) -> None:
    """Against PointNet written out with matrices, from the tensors of the file alone."""
    network = NETWORKS["cls_model_39"]
    (tensors,) = written(network, tmp_path)
    t = {name: tensor.double().numpy() for name, tensor in tensors.items()}

    def layer(x: np.ndarray, linear: str, norm: str) -> np.ndarray:
        x = x @ t[f"{linear}.weight"].squeeze().T + t[f"{linear}.bias"]
        x = (x - t[f"{norm}.running_mean"]) / np.sqrt(t[f"{norm}.running_var"] + 1e-5)
        return np.asarray(x * t[f"{norm}.weight"] + t[f"{norm}.bias"])

    def pooled(x: np.ndarray, prefix: str) -> np.ndarray:
        for number in (1, 2):
            x = np.maximum(layer(x, f"{prefix}conv{number}", f"{prefix}bn{number}"), 0)
        return layer(x, f"{prefix}conv3", f"{prefix}bn3").max(axis=0)

    image = SphericalImage(image.depth[::16], image.points[::16])  # a point is taken by itself: some rows are enough
    points = np.where(image.within(0.5, 63)[..., None], image.points, 0).reshape(-1, 3).astype(np.float64) / 80
    turn = np.maximum(pooled(points, "feat.stn."), 0)
    for number in (1, 2):
        turn = np.maximum(layer(turn, f"feat.stn.fc{number}", f"feat.stn.bn{number + 3}"), 0)
    matrix = (turn @ t["feat.stn.fc3.weight"].T + t["feat.stn.fc3.bias"]).reshape(3, 3) + np.eye(3)
    features = [pooled(points @ matrix, "feat.")]
    for number in (1, 2):
        features.append(np.maximum(layer(features[-1], f"fc{number}", f"bn{number}"), 0))
    features.append(features[-1] @ t["fc3.weight"].T + t["fc3.bias"])
    measured = network.load(tmp_path, "cpu").measure(image)
    assert measured.shape == (1808,)
    np.testing.assert_allclose(measured, np.concatenate(features), rtol=1e-3, atol=1e-4)


def test_rangenet_has_the_published_tensors() -> None:
    """Names and shapes as the published archives have them, and their numbers of parameters (50.4 M of DarkNet-53)."""
    backbone, decoder = NETWORKS["darknet53-1024"].parts()
    shapes = {name: tuple(tensor.shape) for name, tensor in backbone.state_dict().items()}
    shapes |= {name: tuple(tensor.shape) for name, tensor in decoder.state_dict().items()}
    assert shapes["conv1.weight"] == (32, 5, 3, 3)
    assert shapes["enc3.residual_7.conv1.weight"] == (128, 256, 1, 1)
    assert shapes["enc5.conv.weight"] == (1024, 512, 3, 3)
    assert shapes["enc5.residual_3.bn2.running_var"] == (1024,)
    assert shapes["dec5.upconv.weight"] == (1024, 512, 1, 4)
    assert shapes["dec1.upconv.bias"] == (32,)
    assert shapes["dec1.residual.conv1.weight"] == (64, 32, 1, 1)
    assert shapes["dec1.residual.conv2.weight"] == (32, 64, 3, 3)
    parameters = sum(tensor.numel() for part in (backbone, decoder) for tensor in part.parameters())
    assert 50e6 < parameters < 51e6
    assert "enc3.residual_2.conv1.weight" not in NETWORKS["rangenet21_lidm"].parts()[0].state_dict()


def test_frid_has_features_of_16_groups_of_rows(tmp_path: Path, image: SphericalImage) -> None:
    network = NETWORKS["rangenet21_lidm"]
    written(network, tmp_path)
    given = network.images(image)
    assert given.shape == (1, 4, 64, 1024)
    assert (given[0][:, image.depth == 0] == -1).all()
    # whose means over columns a quarter of the columns has as well
    narrow = dataclasses.replace(network, images=lambda image: network.images(image)[..., :256])
    loaded = narrow.load(tmp_path, "cpu")
    features = loaded.measure(image)
    assert features.shape == (512,)
    assert "sha256" in loaded.description
    upper = SphericalImage(np.where(np.arange(64)[:, None] < 32, image.depth, 0), image.points)
    assert np.ptp(loaded.measure(upper) - features) > 1e-3


def test_frd_draws_its_features_as_python_does(image: SphericalImage) -> None:
    output = torch.arange(32 * 64 * 1024, dtype=torch.float32).view(1, 32, 64, 1024)
    random.seed(0)
    expected = random.sample(range(2097152), 4096)
    assert NETWORKS["darknet53-1024"].features(output).tolist() == expected
    given = NETWORKS["darknet53-1024"].images(image)[0].numpy()
    assert (given[:, ~image.within(0.5, 63)] == 0).all()
    pixel = tuple(np.argwhere(image.within(0.5, 63))[0])
    assert given[0][pixel] == pytest.approx((image.depth[pixel] - 12.12) / 12.32, rel=1e-5)
    assert given[4][pixel] == pytest.approx((0.5 - 0.21) / 0.16, rel=1e-5)


def spoiled(tensors: dict[str, torch.Tensor]) -> Iterator[tuple[object, str]]:
    yield {**tensors, "fc3.weight": torch.zeros(16, 255)}, r"'fc3.weight' is \[16, 255\]; it must be \[16, 256\]"
    yield {name: t for name, t in tensors.items() if name != "fc1.bias"}, r"tensor 'fc1.bias' is missing"
    yield {**tensors, "fc4.bias": torch.zeros(1)}, r"tensor 'fc4.bias' is unknown"
    yield {**tensors, "fc1.bias": torch.full((512,), math.nan)}, r"'fc1.bias' holds values that are not finite"
    yield [1, 2], r"it holds a list; it must hold tensors by name"
    yield {"fc1.bias": Path("/")}, r"not a weight file of torch"


def test_other_and_random_weights_are_refused(tmp_path: Path) -> None:
    network = NETWORKS["cls_model_39"]
    (tensors,) = written(network, tmp_path)
    file = tmp_path / network.files
    for content, message in spoiled(tensors):
        torch.save(content, file)
        with pytest.raises(LidarDraftError, match=rf"cls_model_39.pth: .*{message}"):
            network.load(tmp_path, "cpu")
    file.write_bytes(b"PK\x03\x04 not a model")
    with pytest.raises(LidarDraftError, match=r"cls_model_39.pth: not a weight file of torch"):
        network.load(tmp_path, "cpu")
    written(network, tmp_path, learned=False)
    with pytest.raises(LidarDraftError, match="these weights are random"):
        network.load(tmp_path, "cpu")


def test_networks_score_where_their_files_are(
    tmp_path: Path, sets: tuple[Scans, Scans, list[Path], list[Path]], monkeypatch: pytest.MonkeyPatch
) -> None:
    *_, real, made = sets
    network = NETWORKS["cls_model_39"]

    def few_rows(image: SphericalImage) -> torch.Tensor:
        return network.images(SphericalImage(image.depth[::16], image.points[::16]))

    monkeypatch.setitem(NETWORKS, "cls_model_39", dataclasses.replace(network, images=few_rows))
    written(network, tmp_path / "weights")
    scores = scored("r2dm", real[:4], made[:2], networks=tmp_path / "weights")
    assert scores["FPD"].value > 0
    assert len(scores["FPD"].floor) == 10
    assert "cls_model_39.pth, sha256" in scores["FPD"].network
    assert "darknet53-1024/backbone" in scores["FRD"].left_out
    assert scores["MMD"].value == scored("r2dm", real[:4], made[:2])["MMD"].value
