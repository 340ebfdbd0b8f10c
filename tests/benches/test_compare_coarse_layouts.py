"""The quick coarse layouts of streets have the statistics of the solver of sentences, which they imitate."""

import numpy as np

from compare_coarse_layouts import compare_solver
from lidardraft.streets.street import StreetConfig, make_street
from tallies import FEWEST, Tally, drift

CONFIG = StreetConfig()
# What streets have in sizes that the solver cannot make; docs/how-to/streets.md says why.
OTHERWISE = {
    *("fence: fence", "wall: wall", "hedge: vegetation", "bush: vegetation", "pole: pole", "truck: truck"),
    "traffic-sign: traffic-sign",
}


def test_things_are_drawn_as_the_solver_of_sentences_draws_them():
    tallies = compare_solver(make_street(seed=seed, config=CONFIG) for seed in range(8))
    alike = {name: by for name, by in tallies.items() if name not in OTHERWISE}
    assert {"car: car", "van: car", "house: building", "building: building", "tree: trunk"} <= set(alike)
    assert drift(alike, "solver", "quick") == []
    places = [text for text in drift(tallies, "solver", "quick") if not text.endswith("possible")]
    assert places == []


def coarse(size: float, number: int) -> Tally:
    tally = Tally()
    values = size + np.random.default_rng(0).normal(0.0, 0.1, number)
    tally.add(count=[number], length=values, width=values, height=values, yaw=10 * values)
    return tally


def test_drift_is_what_neither_tolerance_nor_chance_explains():
    by = {"real": coarse(1.0, 400), "same": coarse(1.02, 400), "longer": coarse(1.3, 400), "fewer": coarse(1.0, 200)}
    assert drift({"car": by}, "real", "same") == []
    assert drift({"car": by}, "real", "fewer") == ["car: count 200.00, not 400.00"]
    assert [text.split()[1] for text in drift({"car": by}, "real", "longer")] == ["yaw", "0.77"]
    few = {"real": coarse(1.0, FEWEST - 1), "longer": coarse(1.3, FEWEST - 1)}
    assert drift({"car": few}, "real", "longer") == []
