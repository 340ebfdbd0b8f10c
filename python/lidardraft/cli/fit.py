"""`lidardraft fit`: a sensor file from a user's recordings."""

from __future__ import annotations

import argparse
import itertools
import math
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lidardraft.cli.arguments import add_log, add_reading, read_sensor, reading, whole_number
from lidardraft.cli.command import add_json, report, say
from lidardraft.cli.inputs import scan_files
from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.scene.sensor import Sensor

if TYPE_CHECKING:
    from lidardraft.calibration.fit import Fit
    from lidardraft.formats.recording import Recording

_MOST_LOST = 0.1  # of the points; for suitable recordings less than 0.01
_DARK, _NOISE_AT = 0.10, 30.0  # a reflectance, and a range [m], at which figures are printed
_LOOKED_AT = 4  # scans, evenly spread, whose points are projected
_MOST_JUDGED = 24  # scans of either side, evenly spread, and of streets
_MOST_OF_LOG = 32  # scans, evenly spread
_HELD_BACK = 0.25  # of the scans, the last ones, judge the fit if no others are named


def fit(arguments: argparse.Namespace) -> None:
    """Write the sensor file of recordings, and report the findings."""
    from lidardraft.calibration.fit import fit_sensor

    output = Path(arguments.output)
    if output.suffix != ".json":
        raise FormatError(f"{output}: a sensor file ends in .json")
    like = None if arguments.like is None else read_sensor(arguments.like)
    recordings, held = _sound_recordings(arguments, scan_files(arguments.scans), scan_files(arguments.judge))
    if not held and len(recordings) > 1:
        count = max(1, round(_HELD_BACK * len(recordings)))
        recordings, held = recordings[:-count], recordings[-count:]
    if len(recordings) == 1:
        say("fitted to one scan alone: where it has no returns from below, the vehicle is taken to hide "
            "the ground, and of rare surfaces it says little; ten scans of different places are enough")  # fmt: skip
    found = fit_sensor(recordings, output.stem, like=like, columns=arguments.columns, num_streets=arguments.streets)
    found.sensor.save(output)
    _report_sensor(arguments, found, [*recordings, *held])
    if held:
        _report_rows(arguments, found, like, recordings, held)
    count = len(recordings)
    report(arguments, f"{output}: fitted to {count} scan{'s' * (count > 1)}", output=str(output), scans=count)


def _sound_recordings(arguments: argparse.Namespace, *paths: list[Path]) -> tuple[list[Recording], ...]:
    """The scans of lists of files without odd ones, each of which is reported."""
    from lidardraft.calibration.beam_table import FEWEST_POINTS
    from lidardraft.calibration.odd_scans import odd_scans, without_rare_lasers
    from lidardraft.formats.recording import Recording, read_recording, with_fields

    def tried(path: Path, frame: int | None) -> Recording | LidarDraftError:
        try:
            return read_recording(path, **(reading(arguments) | {"frame": frame}))
        except LidarDraftError as error:
            return error

    scans = [_scans_of(arguments, each) for each in paths]
    found = {one: tried(*one) for one in itertools.chain(*scans)}
    read = {key: one for key, one in found.items() if isinstance(one, Recording)}
    refused = [one for one in found.values() if isinstance(one, LidarDraftError)]
    odd = odd_scans(list(read.values()))
    refused += [FormatError(f"{list(read.values())[number].name}: {why}") for number, why in odd.items()]
    sound = [key for number, key in enumerate(read) if number not in odd]
    if not set(sound).intersection(scans[0]):
        raise refused[0]
    for error in refused:
        say(f"left out: {error}")
    if all(read[key].intensity is None for key in sound):
        say(f"{sound[0][0]}: it has no intensities{with_fields(sound[0][0])}: none are fitted")
    kept, rare = without_rare_lasers([read[key] for key in sound])
    if rare:
        rings = ", ".join(map(str, rare))
        say(f"left out: rings {rings}, each with fewer than {FEWEST_POINTS} returns in all of the scans together")
    by_scan = dict(zip(sound, kept, strict=True))
    return tuple([by_scan[key] for key in each if key in by_scan] for each in scans)


def _scans_of(arguments: argparse.Namespace, paths: list[Path]) -> list[tuple[Path, int | None]]:
    """The scans of files with their numbers in logs: that of --frame, or some of all, evenly spread."""
    from lidardraft.formats.recording import frames_in, is_log

    found = list[tuple[Path, int | None]]()
    for path in paths:
        numbers: list[int] | list[int | None] = [arguments.frame]
        if arguments.frame is None and is_log(path):
            with suppress(LidarDraftError):  # reading raises it again, and reports it
                count = frames_in(path, arguments.topic)
                numbers = sorted({round(at) for at in np.linspace(0, count - 1, min(count, _MOST_OF_LOG))})
                if count > _MOST_OF_LOG:
                    say(f"{path}: of its {count} scans {_MOST_OF_LOG} are read, evenly spread; --frame takes one")
        found += [(path, number) for number in numbers]
    return found


def _report_sensor(arguments: argparse.Namespace, found: Fit, recordings: list[Recording]) -> None:
    """Report the constants of the sensor, and how well the recordings fit it."""
    from lidardraft.calibration.receiver import at_limits

    sensor, table, model = found.sensor, found.table, found.sensor.model
    assert model is not None
    moved, shared = _lost(found, recordings)
    if moved > _MOST_LOST:
        say(f"{moved:.0%} of the points look like those of other lasers: their order is not laser by "
            "laser, or the motion of the vehicle is taken out")  # fmt: skip
    reach = math.sqrt(_DARK / model.detection_threshold)  # m; the power is 1 here, and falls with the squared range
    weak = math.hypot(sensor.range_sigma, model.jitter * _NOISE_AT / reach)
    anyhow, at_edges = (1 - math.exp(-exponent) for exponent in (model.drop_exponent, model.edge_drop))
    hidden = float(sensor.blocked_pixels.mean())
    off = f"{1e3 * table.residual:.2f} mm ({1e3 * table.angle_residual:.3f} mrad) off"
    lines = [
        f"lasers: {len(table.rings)}, returns {off}",
        f"points lost in projection: {moved:.2%}, {shared:.2%} more share a pixel at {sensor.columns} columns",
        f"ranges: {sensor.min_range:g} to {sensor.max_range:g} m; mounted {sensor.mount_height:.2f} m over the road",
        f"hidden by the vehicle: {hidden:.1%} of the firings",
        f"range noise: {1e3 * sensor.range_sigma:.1f} mm of strong echoes, {1e3 * weak:.0f} mm of a surface "
        f"{_NOISE_AT:g} m away with a reflectance of {_DARK:.2f}",
        f"detected: {reach:.0f} m far at a reflectance of {_DARK:.2f}",
        f"dropped: {anyhow:.2%} at any range, {at_edges:.1%} more where a beam has several echoes",
        f"echoes: one within {model.pulse_length:.2f} m",
        f"power: {model.texture:.2f} from patch to patch, {model.speckle:.2f} from firing to firing",
    ]
    if model.intensity_curve is not None:
        lines.append(f"intensity: quantiles agree to {found.intensity_residual:.3f} of 1")
    facts = {"lasers": len(table.rings), "residual": table.residual, "lost": moved, "shared": shared}
    facts |= {"hidden": hidden, "range_noise": sensor.range_sigma, "weak_range_noise": weak, "reach": reach}
    facts |= {"dropped": anyhow, "dropped_at_edges": at_edges, "intensity_residual": found.intensity_residual}
    report(arguments, "\n".join(lines), **facts)
    for name, limit in at_limits(model, sensor.range_sigma).items():
        say(f"{name} is at the limit of its search, {limit:g}: streets come no nearer to the scans")


def _lost(found: Fit, recordings: list[Recording]) -> tuple[float, float]:
    """The share of the points of some recordings that the sensor puts in another laser's row or in none, and the share
    in the pixel of another point."""
    points = moved = shared = 0
    for one in recordings[:: max(1, len(recordings) // _LOOKED_AT)]:
        row, column, _ = found.sensor.pattern.project(one.points.astype(np.float64))
        points += len(row)
        moved += int((row != found.table.rows(one)).sum())
        shared += len(row) - len(np.unique(row.astype(np.int64) * found.sensor.columns + column))
    return moved / points, shared / points


def _report_rows(
    arguments: argparse.Namespace, found: Fit, like: Sensor | None, recordings: list[Recording], held: list[Recording]
) -> None:
    """Report the effect of the fit on scans that it has not used."""
    from lidardraft.calibration.fit import judged, sweeps_of

    usual = like or Sensor(name="typical", elevations=found.sensor.elevations, columns=1)
    before = replace(found.sensor, model=usual.assumed_model, range_sigma=usual.range_sigma, max_range=usual.max_range)
    fitted_to, judging = (
        sweeps_of(scans[:: max(1, len(scans) // _MOST_JUDGED)], found.table, found.sensor.columns)
        for scans in (recordings, held)
    )
    rows = judged(before, found.sensor, fitted_to, judging, min(arguments.streets, _MOST_JUDGED))
    beside = f"{len(held)} scan{'s' * (len(held) > 1)}"
    lines = [f"\nscans of streets beside {beside} that nothing was fitted to, before and after:\n"]
    lines += [
        "| property | before | after | fitted scans | ratio before | ratio after |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        unit = row.recorded if row.recorded > 0 else math.nan
        cells = (row.before, row.after, row.recorded, row.before / unit, row.after / unit)
        lines.append(f"| {row.name} | {' | '.join('-' if math.isnan(cell) else f'{cell:.3g}' for cell in cells)} |")
    report(arguments, "\n".join(lines), judged_on=len(held), properties=[asdict(row) for row in rows])


def fit_options(parser: argparse.ArgumentParser) -> None:
    """The options of `fit`."""
    text = (
        "scans of one sensor, or folders of them: KITTI .bin (and labels beside it), nuScenes .pcd.bin, PandaSet "
        ".pkl.gz, .pcd with rings or rows, .npz, ROS 2 bags, Ouster .pcap and .osf"
    )
    parser.add_argument("scans", nargs="+", metavar="SCAN", help=text)
    parser.add_argument("-o", "--output", required=True, metavar="SENSOR.json", help="file of the sensor")
    text = "scans that the fit is judged on (default: a quarter of SCANs, the last ones, is kept back for that)"
    parser.add_argument("--judge", nargs="+", default=[], metavar="SCAN", help=text)
    text = "preset or sensor file for constants that no scan shows, such as the divergence (default: typical values)"
    parser.add_argument("--like", metavar="SENSOR", help=text)
    add_reading(parser)
    add_log(parser)
    text = "firings in a turn of the sensor that is written (default: those of the scans, in fours)"
    parser.add_argument("--columns", type=whole_number(8), metavar="N", help=text)
    text = "streets to compare the scans with (default 32)"
    parser.add_argument("--streets", type=whole_number(4), default=32, metavar="N", help=text)
    add_json(parser)
