"""The quick drawings of streets have the statistics of the real drafting code that they stand in for."""

import numpy as np
import pytest

from compare_drawings import IN_PIECES, Tallies, Tally, compare_clusters, compare_solver, rows
from lidardraft.streets.street import StreetConfig, make_street

CONFIG = StreetConfig()


def drift(tallies: Tallies, real: str, quick: str, least: float) -> list[str]:
    """What is drawn otherwise than by the real code, of the classes with `least` shapes a scan."""
    found = []
    for label, by in tallies.items():
        mine, theirs = by[quick], by[real]
        if len(theirs.values["length"]) < 20 or not theirs.mean("count") >= least:
            continue
        # a class in pieces is halved in other places, into whole fronts and splinters: their mean is the same
        loose, middle = (2.0, Tally.mean) if label in IN_PIECES else (1.0, Tally.median)
        if not 0.6 < mine.mean("count") / theirs.mean("count") < 1.7:
            found.append(f"{label}: count {mine.mean('count'):.2f}, not {theirs.mean('count'):.2f}")
        for name in ("length", "width", "height"):
            ours, other = middle(mine, name), middle(theirs, name)
            if abs(ours - other) > loose * (0.2 * max(other, 0.3) + 0.35 * theirs.spread(name)):
                found.append(f"{label}: {name} {ours:.2f}, not {other:.2f}")
        for name, slack in (("along", 0.2), ("across", 0.4), ("yaw", 4.0)):
            ends = mine.spread(name), theirs.spread(name)
            # the spread of few is chance
            if len(theirs.values[name]) > 50 and not ends[1] / 2.5 - slack < ends[0] < 2.5 * ends[1] + slack:
                found.append(f"{label}: {name} spreads {ends[0]:.2f}, not {ends[1]:.2f}")
        if theirs.values["turned"] and abs(mine.mean("turned") - theirs.mean("turned")) > 0.15:
            found.append(f"{label}: turned {mine.mean('turned'):.2f}, not {theirs.mean('turned'):.2f}")
        if theirs.values["agrees"] and abs(mine.mean("agrees") - theirs.mean("agrees")) > 0.15:
            found.append(f"{label}: agrees {mine.mean('agrees'):.2f}, not {theirs.mean('agrees'):.2f}")
    return found


def test_things_are_drawn_as_the_solver_of_sentences_draws_them():
    tallies = compare_solver(make_street(seed, CONFIG) for seed in range(8))
    # the kinds whose sizes in streets are those that people speak of
    common = {"car: car", "van: car", "house: building", "person: person", "building: building"}
    spoken = {name: by for name, by in tallies.items() if name in common}
    assert set(spoken) == common
    # all people of the solver stride; those who stand in a street are drawn slim
    assert [found for found in drift(spoken, "solver", "quick", 0.9) if "person: length" not in found] == []


def test_every_line_of_the_table_has_every_column():
    table = list(rows(compare_solver(make_street(seed, CONFIG) for seed in range(2))))
    assert {line.count("|") for line in table} == {table[0].count("|")}
    assert np.unique([line.split("|")[2].strip() for line in table[2:]]).tolist() == ["quick", "solver"]


@pytest.fixture(scope="module")
def clustered() -> Tallies:
    return compare_clusters((make_street(seed, CONFIG) for seed in range(20)), CONFIG)


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("suffix", ["", " numbered"])
def test_clusters_are_drawn_as_clustering_draws_them(clustered: Tallies, suffix: str):
    # a wall falls into splinters there, and one of 0.2 m is the median
    things = {name: by for name, by in clustered.items() if name != "wall"}
    assert drift(things, f"clusters{suffix}", f"quick{suffix}", 1.0) == []
