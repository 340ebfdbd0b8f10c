"""Packet captures of Ousters are scans of the sensor of their metadata."""

import json
import os
import shutil
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from lidardraft.cli.inputs import sensor_of_file
from lidardraft.cli.main import main
from lidardraft.errors import FormatError, MissingExtraError
from lidardraft.formats.ouster import metadata_beside, read_ouster_capture, read_ouster_metadata
from lidardraft.formats.recording import frames_in, read_points, read_recording
from small_recordings import BEAMS, COLUMNS, METADATA, write_capture

REASON = "ouster-sdk is not installed; in an environment of its own: pip install 'lidardraft[ouster]' pytest"


@pytest.fixture
def sdk() -> None:
    pytest.importorskip("ouster.sdk", reason=REASON)


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    """Two frames: rings of lasers 5 m to 20 m away, a beam without returns, then all 1 m further."""
    first = np.repeat(np.arange(5000, 5000 + 1000 * BEAMS, 1000, np.uint32)[:, None], COLUMNS, axis=1)
    first[3] = 0
    path = tmp_path / "drive.pcap"
    write_capture(path, [first, first + 1000])
    return path


def test_the_first_whole_frame_is_read(capture: Path) -> None:
    points, fields = read_ouster_capture(capture)
    distance = np.linalg.norm(points, axis=1)
    assert len(points) == (BEAMS - 1) * COLUMNS
    np.testing.assert_allclose(distance, (5 + BEAMS - 1 - fields["ring"]), atol=1e-3)  # ring 0 is the highest
    assert (fields["intensity"] == 51).all()
    assert read_recording(capture).intensity == pytest.approx(0.2)
    assert set(fields["column"]) == set(range(COLUMNS))
    assert (points[fields["ring"] == 0, 2] > 0).all()


def test_a_frame_is_chosen_and_fragments_of_datagrams_are_joined(tmp_path: Path) -> None:
    path = tmp_path / "drive.pcap"
    ranges = np.full((BEAMS, COLUMNS), 9000, np.uint32)
    write_capture(path, [ranges, ranges + 1000, ranges + 2000], largest=1480)
    assert frames_in(path) == 3
    for frame in range(3):
        points = read_recording(path, frame=frame).points
        np.testing.assert_allclose(np.linalg.norm(points, axis=1), 9 + frame, atol=1e-3)
    with pytest.raises(FormatError, match=r"drive\.pcap: there is no whole frame 3; it has 3, from 0 on"):
        read_points(path, frame=3)


def test_tags_of_a_vlan_are_skipped(capture: Path) -> None:
    points, _ = read_ouster_capture(capture)
    data = capture.read_bytes()
    tagged, at = data[:24], 24
    while at < len(data):
        length = int.from_bytes(data[at + 8 : at + 12], "little")
        packet = data[at + 16 : at + 16 + length]
        tagged += data[at : at + 8] + 2 * (length + 4).to_bytes(4, "little") + packet[:12] + b"\x81\0\0\5" + packet[12:]
        at += 16 + length
    capture.write_bytes(tagged)
    np.testing.assert_array_equal(read_ouster_capture(capture)[0], points)


def test_a_capture_that_begins_within_a_frame(capture: Path) -> None:
    whole = capture.read_bytes()
    size = (len(whole) - 24) // (2 * COLUMNS // 16)  # of a record
    capture.write_bytes(whole[:24] + whole[24 + 5 * size :])
    _, fields = read_ouster_capture(capture)
    assert len(fields["ring"]) == BEAMS * COLUMNS  # of the second frame: its beam 3 returns
    capture.write_bytes(whole[: 24 + 20 * size - 7])
    with pytest.raises(FormatError, match=r"drive\.pcap: no frame is whole: the fullest has \d+ columns"):
        read_ouster_capture(capture)


def test_points_lie_in_the_pixels_of_the_sensor_of_the_metadata(capture: Path) -> None:
    recording = read_recording(capture)
    sensor = sensor_of_file(capture)
    assert sensor == read_ouster_metadata(capture.with_suffix(".json"))
    row, column, _ = sensor.pattern.project(recording.points.astype(np.float64))
    np.testing.assert_array_equal(row, recording.ring)
    np.testing.assert_array_equal(column, recording.column)


@pytest.mark.parametrize("window", [(400, 100), (256, 255), (100, 400)])
def test_points_of_a_window_lie_in_its_pixels_over_the_seam_too(tmp_path: Path, window: tuple[int, int]) -> None:
    path = tmp_path / "drive.pcap"
    write_capture(path, [np.full((BEAMS, COLUMNS), 9000, np.uint32)] * 2, window=window)
    recording, sensor = read_recording(path), sensor_of_file(path)
    assert sensor.columns == (window[1] - window[0]) % COLUMNS + 1
    assert len(recording.points) == BEAMS * sensor.columns
    row, column, _ = sensor.pattern.project(recording.points.astype(np.float64))
    np.testing.assert_array_equal(row, recording.ring)
    np.testing.assert_array_equal(column, recording.column)


def test_the_sensor_of_a_window_over_the_seam_looks_to_its_columns(tmp_path: Path) -> None:
    form = METADATA["data_format"] | {"column_window": [400, 100]}
    (tmp_path / "a.json").write_text(json.dumps(METADATA | {"data_format": form, "beam_azimuth_angles": [0] * BEAMS}))
    sensor = read_ouster_metadata(tmp_path / "a.json")
    step = 2 * np.pi / COLUMNS
    expected = np.pi - (400 + np.arange(COLUMNS - 400 + 101)) * step
    assert sensor.shape == (BEAMS, COLUMNS - 400 + 101)
    np.testing.assert_allclose(np.exp(1j * sensor.azimuths[0]), np.exp(1j * expected), atol=1e-9)
    assert sensor.sweep_time == pytest.approx(0.1 * sensor.columns / COLUMNS)


def test_a_capture_is_viewed_and_edited(capture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(capture.parent)
    assert main(["view", "drive.pcap", "-o", "drive.png"]) == 0
    assert main(["edit", "drive.pcap", "--insert", "car at 4,2", "-o", "edited"]) == 0
    assert Path("drive.png").exists()
    assert Path("edited.bin").exists()


def test_captures_that_are_none(capture: Path) -> None:
    whole = capture.read_bytes()
    for data, message in [
        (b"", "not a capture of packets, a pcap"),
        (bytes(100), "not a capture of packets, a pcap"),
        (whole[:24], r"it has no packet of the sensor of drive\.json"),
    ]:
        capture.write_bytes(data)
        with pytest.raises(FormatError, match=rf"drive\.pcap: {message}"):
            read_ouster_capture(capture)
    capture.write_bytes(whole)
    form = {**METADATA["data_format"], "udp_profile_lidar": "LEGACY"}
    capture.with_suffix(".json").write_text(json.dumps(METADATA | {"data_format": form}))
    with pytest.raises(FormatError, match=r"it has no packet of the sensor of drive\.json"):
        read_ouster_capture(capture)


def test_metadata_are_found_beside_a_capture(tmp_path: Path) -> None:
    path = tmp_path / "drive.pcap"
    path.touch()
    (tmp_path / "other.json").write_text("{}")
    with pytest.raises(FormatError, match=r"drive\.json is not beside it, and no other of an Ouster is in its folder"):
        metadata_beside(path)
    for name, found in (("unit", "unit"), ("drive", "drive")):
        (tmp_path / f"{name}.json").write_text(json.dumps(METADATA))
        assert metadata_beside(path) == tmp_path / f"{found}.json"
    (tmp_path / "drive.json").rename(tmp_path / "second.json")
    with pytest.raises(FormatError, match="and 2 others of Ousters are in its folder"):
        metadata_beside(path)


@pytest.mark.skipif(find_spec("ouster") is not None, reason="ouster-sdk is installed")
def test_the_extra_is_named(tmp_path: Path) -> None:
    (tmp_path / "drive.osf").touch()
    with pytest.raises(MissingExtraError, match=r"ouster is not installed; run: pip install 'lidardraft\[ouster\]'"):
        read_points(tmp_path / "drive.osf")


@pytest.mark.usefixtures("sdk")
@pytest.mark.parametrize(("name", "count"), [("single_scan_016", 101762), ("pose_delta_2_128", 203569)])
def test_real_osf_files_lie_in_the_rows_of_their_sensor(name: str, count: int) -> None:
    path = Path(os.environ.get("LIDARDRAFT_DATA", ""), "permissive", "ouster", f"{name}.osf")
    if not path.exists():
        pytest.skip("no recordings: LIDARDRAFT_DATA is not set")
    recording, sensor = read_recording(path), sensor_of_file(path)
    assert sensor is not None
    assert len(recording.points) == count
    row, _, _ = sensor.pattern.project(recording.points.astype(np.float64))
    assert (row == recording.ring).mean() > 0.999


@pytest.mark.parametrize(
    ("name", "count", "metres", "intensity"),
    [("OS-0-128-U1_v2.3.0_1024x10", 97299, 8.48675, 15.12685), ("OS-1-32-G_v2.1.1_1024x10", 27310, 17.72375, 19.93757)],
)
def test_real_captures_lie_in_the_rows_of_their_sensor(
    name: str, count: int, metres: float, intensity: float, tmp_path: Path
) -> None:
    folder = Path(os.environ.get("LIDARDRAFT_DATA", ""), "permissive", "ouster")
    if not folder.exists():
        pytest.skip("no recordings: LIDARDRAFT_DATA is not set")
    path = Path(shutil.copy(folder / f"{name}.pcap", tmp_path / "a.pcap"))
    shutil.copy(folder / f"{name}.json", tmp_path / "a.json")
    points, fields = read_ouster_capture(path)
    ring, recorded = fields["ring"], np.linalg.norm(points, axis=1)
    assert len(points) == count
    assert recorded.mean() == pytest.approx(metres, abs=1e-4)  # as a second decoder, written apart, had it
    assert fields["intensity"].mean() == pytest.approx(intensity, abs=1e-4)
    far = recorded > 2  # m; nearer, a beam's origin on the head counts
    row, _, _ = read_ouster_metadata(tmp_path / "a.json").pattern.project(points[far].astype(np.float64))
    assert (row == ring[far]).mean() > 0.999
