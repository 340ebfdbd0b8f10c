"""The report of how well details obey, on little."""

import numpy as np
import pytest

from lidardraft import layout_from_text
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import CLASSES, GROUND
from report_detail import SENTENCES, new_counts, of_recording, of_sentences, of_streets, report

OBJECTS = [row.id for row in CLASSES[1:] if row.name not in GROUND]


def test_details_obey_a_coarse_layout_as_well_as_the_street_that_it_is_of() -> None:
    counts = new_counts()
    for number in range(2):
        of_streets(counts, number)
    near, total = np.array([found[:, OBJECTS].sum(axis=1) for found in counts.values()]).T
    shares = dict(zip(counts, near / total, strict=True))
    for style in ("text", "cloud", "picture", "boxes"):
        assert shares[style] > shares[f"{style}: street"], style
        assert 0.6 < shares[style] < 0.95


def test_the_details_of_sentences_obey_and_the_table_says_so() -> None:
    counts = new_counts()
    times = of_sentences(counts, SENTENCES[2:3], 1)
    assert len(times) == 1
    found = counts["sentences"]
    assert found[0, OBJECTS].sum() / found[1, OBJECTS].sum() > 0.7
    lines = report(counts).splitlines()
    assert lines[0] == "| | sentences | returns |"
    assert next(line for line in lines if line.startswith("| road")).split(" | ")[1] == "1.00"
    assert lines[-1].startswith("| all objects | 0.")


def test_a_sweep_is_held_against_the_casts_of_its_clustering() -> None:
    sensor = PRESETS["pandar64"]
    scan = raycast(layout_from_text("three cars ahead and a building on the left", seed=1), sensor)
    points = np.zeros((*sensor.shape, 3), np.float32)
    points[scan.valid] = scan.points()
    counts = new_counts()
    layout = of_recording(counts, Sweep(points, scan.label, np.zeros(sensor.shape, np.float32)), sensor)
    assert layout.provenance["source"] == "point cloud"
    assert counts["bare"][1].sum() == counts["detailed"][1].sum() == pytest.approx(scan.valid.sum(), rel=0.02)
    assert (counts["detailed"][0, 1:4] > 0.5 * counts["detailed"][1, 1:4]).all()
