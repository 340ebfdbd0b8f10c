"""Can a classifier tell made scans from recorded ones? `make report-two-sample`.

    python benches/report_two_sample.py [--num 60] [--sensor NAME_OR_FILE ...] [--scans FOLDER ...] [--data FOLDER]

The recordings are KITTI's (an HDL-64E) in FOLDER, by default LIDARDRAFT_DATA. Without `--sensor` or `--scans`, the rows
are recordings against recordings of other drives, streets by the preset hdl64e, streets by a sensor that is fitted here
to a drive that judges nothing, the scans of this drive, which no sensor that is fitted to it can be expected to beat,
and streets by the preset pandar64 beside PandaSet's two places. `--sensor` makes streets with a preset or a sensor of
`lidardraft fit`; `--scans` takes scans that `simulate`, `generate` or another program wrote, all that are in the
folder. A cell is the AUC: 0.5 is not told apart, 1 always; below the table, what tells most in each family alone.
`two_sample.py` says how.
"""

from __future__ import annotations

import argparse
import itertools
import os
from collections.abc import Callable
from pathlib import Path

import recordings
from lidardraft.calibration.fit import fit_sensor
from lidardraft.cli.arguments import read_sensor
from lidardraft.formats.recording import read_recording
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.streets import StreetConfig, streets
from recordings import Groups
from result_page import write_page
from two_sample import ALL, FAMILIES, TwoSample, shown_pixels, two_sample

SEED = 777_000  # no training uses it
FITTED_TO = "raw 0005"  # which judges no streets
ROWS, COLUMNS = 64, 1024
PANDAR64 = PRESETS["pandar64"]
PAGE = (
    "AUC of a classifier that tells crops of 64 x 128 pixels of streets from recordings, one drive left out at a time."
)
PARTS = 4  # at least, that the recordings are in: each is left out once


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--num", type=int, default=60, help="streets a sensor, a scan each")
    parser.add_argument("--sensor", action="append", default=[], help="a preset or a .json file to scan streets with")
    parser.add_argument("--scans", type=Path, action="append", default=[], help="a folder of .bin, .pcd or .npz scans")
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("LIDARDRAFT_DATA", "")), help="recordings")
    parser.add_argument("--features", type=int, default=3, help="features to print for each family")
    parser.add_argument("--page", action="store_true", help="write the table to its page in benches/results")
    given = parser.parse_args()
    if given.num < PARTS or given.features < 0:
        parser.error(f"--num is {PARTS} or more, --features 0 or more")
    if not given.data.name or not (given.data / "kitti").is_dir():
        print("Skipped: no recordings under kitti/; name their folder in LIDARDRAFT_DATA or --data.")
        return
    drives = recordings.hdl64e(given.data, COLUMNS).plain
    shown = shown_pixels([sweep for sweeps in drives.values() for sweep in sweeps])
    judges = parted({name: sweeps for name, sweeps in drives.items() if name != FITTED_TO})
    made: dict[str, Callable[[], list[Sweep]]] = {
        f"streets, {name}": lambda name=name: street_sweeps(read_sensor(name), given.num) for name in given.sensor
    } | {f"{folder}": lambda folder=folder: scans_in(folder) for folder in given.scans}
    head = f"| scans | {ALL} | {' | '.join(FAMILIES)} |\n|---|{'---:|' * (len(FAMILIES) + 1)}"
    print(head)
    told = {}
    if not made:
        others = {name: sweeps for name, sweeps in drives.items() if name != "object"}
        told["recordings of other drives"] = two_sample(others, drives["object"], shown)
        made["streets"] = lambda: street_sweeps(PRESETS["hdl64e"], given.num)
        made["streets, fitted sensor"] = lambda: street_sweeps(fitted(given.data), given.num)
        made["the drive fitted to"] = lambda: drives[FITTED_TO]
    for title, found in told.items():
        print(row(title, found), flush=True)
    for title, sweeps in made.items():
        told[title] = two_sample(judges, sweeps(), shown)
        print(row(title, told[title]), flush=True)
    places = {} if given.sensor or given.scans else recordings.pandar64(given.data, PANDAR64.columns).labelled
    if places:
        title = "streets, Pandar64, beside PandaSet"
        pandar64 = [Sweep.by_azimuth(scan) for scan in street_scans(PANDAR64, given.num)]
        everywhere = shown_pixels([sweep for group in places.values() for sweep in group])
        told[title] = two_sample(places, pandar64, everywhere)
        print(row(title, told[title]), flush=True)
    for title, found in told.items():
        print("\n" + "\n".join(telling(title, found, given.features)))
    if given.page:
        write_page("report_two_sample", PAGE, "\n".join([head, *(row(title, found) for title, found in told.items())]))


def parted(drives: Groups) -> Groups:
    """The drives, and frames of many drives ("object") in parts that have none in common."""
    frames = drives.get("object", [])
    count = min(PARTS - 1, len(frames))
    return {name: sweeps for name, sweeps in drives.items() if name != "object"} | {
        f"object {part}": frames[part::count] for part in range(count)
    }


def street_scans(sensor: Sensor, num: int) -> list[RangeImage]:
    """A scan of each of `num` streets."""
    pairs = streets(seed=SEED, config=StreetConfig(sensor=sensor, poses_per_street=1))
    return [pair.scan for pair in itertools.islice(pairs, num)]


def street_sweeps(sensor: Sensor, num: int) -> list[Sweep]:
    """The same as sweeps."""
    return [Sweep.from_image(scan) for scan in street_scans(sensor, num)]


def fitted(folder: Path) -> Sensor:
    """The sensor of the drive that judges nothing, as `lidardraft fit --like hdl64e --columns 1024` makes it."""
    recorded = recordings.hdl64e_drive(folder)
    return fit_sensor(recorded, "fitted", like=PRESETS["hdl64e"], columns=COLUMNS).sensor


def scans_in(folder: Path) -> list[Sweep]:
    """The scans of a folder, in order of their names; those with a NAME.sensor.json beside them by its rays."""
    files = sorted(path for path in folder.iterdir() if path.suffix in (".bin", ".pcd", ".npz"))
    # `Scan.save` writes an .npz beside its points.
    files = [path for path in files if path.suffix != ".npz" or path.with_suffix(".bin") not in files]
    return [_sweep(path) for path in files]


def _sweep(path: Path) -> Sweep:
    recorded = read_recording(path)
    sensor = path.with_suffix(".sensor.json")
    if sensor.exists():  # a laser without a return is missing in the order of the points
        image = RangeImage.project(recorded.points, Sensor.load(sensor), intensity=recorded.intensity)
        return Sweep.from_image(image)
    return Sweep.from_points(recorded.points, recorded.ring, height=ROWS, columns=COLUMNS, intensity=recorded.intensity)


def row(title: str, found: TwoSample) -> str:
    """A row of the table."""
    cells = (f"{found.auc[name]:.3f}" if name in found.auc else "" for name in (ALL, *FAMILIES))
    return f"| {title} | {' | '.join(cells)} |"


def telling(title: str, found: TwoSample, count: int) -> list[str]:
    """What tells most in each family: how often the made crop has more, and both medians."""
    lines = [f"{title}: share of pairs in which the made crop has more (medians recorded, made)"]
    for family in FAMILIES:
        gaps = [(name, gap) for name, gap in found.features.items() if name.startswith(f"{family}.")][:count]
        said = [
            f"{name.split('.', 1)[1]} {gap.made_is_more:.2f} ({gap.recorded:.3g}, {gap.made:.3g})" for name, gap in gaps
        ]
        lines += [f"- {family}: {'; '.join(said)}"] if said else []
    return lines


if __name__ == "__main__":
    main()
