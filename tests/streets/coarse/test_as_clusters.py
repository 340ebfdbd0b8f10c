"""A street as clustering finds it."""

import numpy as np
import pytest
from scanned import EGO, NAMES, SCAN, SENSOR, VISIBLE, made

from lidardraft.drafting.cloud.layout import layout_from_cloud
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.streets.coarse.as_clusters import ClusterStyle


def share_of_cars(table: ShapeTable) -> float:
    """How many of the returns from cars the cast layout has within 0.5 m."""
    coarse = table.scan(SENSOR, SENSOR.poses_in_motion(VISIBLE.pose, (EGO.speed, 0.0, 0.0)))
    both = SCAN.valid & coarse.valid & (SCAN.label == NAMES.index("car"))
    return float((np.abs(coarse.depth - SCAN.depth)[both] < 0.5).mean())


def test_clusters_are_of_the_classes_of_real_clusters_and_where_they_were_seen():
    table = made(ClusterStyle())
    numbers = set(SCAN.instance[SCAN.valid].tolist()) - {0}
    assert set(table.instances.tolist()) - {0} <= numbers
    # the layout of what was seen agrees with it nearly as far as that of real clusters, as one street's few cars tell
    points, found = SCAN.points() @ VISIBLE.pose[:3, :3].T, SCAN.valid
    height = float(VISIBLE.pose[2, 3])
    labels, numbers = SCAN.label[found], SCAN.instance[found]
    real = ShapeTable.from_primitives(layout_from_cloud(points, labels, instances=numbers, sensor_height=height))
    # clustering keeps small, far clusters too
    assert {NAMES[k] for k in table.labels} <= {NAMES[k] for k in real.labels}
    agreed = np.mean([share_of_cars(made(ClusterStyle(), seed)) for seed in range(5)])
    assert agreed == pytest.approx(share_of_cars(real), abs=0.15)
    assert agreed > 0.55


def test_points_without_numbers_merge_neighbours_and_lose_what_is_small():
    count, counted = {}, [NAMES.index("car"), NAMES.index("person")]
    for numbered in (True, False):
        tables = [made(ClusterStyle(numbered=numbered), seed) for seed in range(5)]
        count[numbered] = np.mean([np.isin(t.labels, counted).sum() for t in tables])
    assert 0.4 * count[True] < count[False] < 0.95 * count[True]
