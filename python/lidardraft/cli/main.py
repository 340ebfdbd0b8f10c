"""The `lidardraft` command."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Collection, Sequence

import lidardraft
from lidardraft.cli.command import Command, Parser, add_commands, run

_FIRST = """\
start here:
  lidardraft simulate --text "a bus ahead, trees along both sides" -o scans
  lidardraft view scans/000000.bin

`lidardraft COMMAND --help` lists the options of a command; `lidardraft doctor` checks this installation;
`lidardraft-train --help` trains weights of your own.
"""
_CLI = "lidardraft.cli."
COMMANDS = {
    "simulate": Command(
        _CLI + "scans",
        "Make labelled LiDAR scans by physics alone, from a sentence, a layout, a 3D model, a labelled scan, or of "
        "streets that are made up; with --frames a sequence in which everything moves.",
        'lidardraft simulate --text "a bus ahead, people on the sidewalks" --sensor os1-128 -n 4 -o scans/',
    ),
    "generate": Command(
        _CLI + "scans",
        "Make labelled LiDAR scans with the diffusion model, from a sentence, a layout, a 3D model or a labelled scan.",
        'lidardraft generate --text "a crossroads with a bus" --weights paper-small -o generated/',
    ),
    "studio": Command(
        _CLI + "studio",
        "Open a page in the browser: type a sentence or give a file, drag objects, and the scan follows; play it, and "
        "keep scans, data sets and the commands that make them again.",
        'lidardraft studio --text "a bus ahead, trees along both sides"',
    ),
    "dataset": Command(
        _CLI + "dataset",
        "Make a data set of many labelled scans by a recipe: sentences, layouts and streets, sensors and weather, in "
        "shares and ranges.",
        "lidardraft dataset recipe.toml -n 10000 --jobs 8 -o set/",
    ),
    "view": Command(
        _CLI + "view",
        "Make a picture of a scan (.bin with the .label beside it, .pcd.bin, .pcd, .ply, .npy, .las, .npz, .pkl.gz or "
        "a log), a range image (.npz), a file of training pairs (.npz) or a layout (.json); an HTML page of a scan; or "
        "a film of a folder of scans.",
        "lidardraft view scans/000000.bin -o scan.html",
    ),
    "edit": Command(
        _CLI + "edit",
        "Insert, remove, move and replace objects in a recorded scan, with the shadows that they throw; or list its "
        "objects.",
        'lidardraft edit 000000.bin --insert "car at 12,3 yaw 90" -o edited',
    ),
    "export": Command(
        _CLI + "dataset",
        "Write folders of scans as one data set in a format that other people's readers open.",
        "lidardraft export drives/ --format nuscenes -o nuscenes/",
    ),
    "draft": Command(
        _CLI + "layouts",
        "Make a layout, a file of boxes and other shapes that can be edited, from a sentence, a labelled scan, a "
        "sketch, boxes, a 3D model or a Blender script.",
        'lidardraft draft --text "two parked cars on the left" -o layout.json',
    ),
    "raycast": Command(
        _CLI + "layouts",
        "Get the depth, class and instance images of a layout as a sensor's rays meet it, in an .npz file, the "
        "condition image of the diffusion model; and the layout beside it, from which `observe` has the objects.",
        "lidardraft raycast --layout layout.json --sensor vlp16 -o cast.npz",
    ),
    "observe": Command(
        _CLI + "scans",
        "Add ray drop, noise and intensity to the casts of another renderer, which keep their labels: range and class "
        "images, or clouds of CARLA's semantic LiDAR; with the boxes, poses and times that come with them.",
        "lidardraft observe cast.npz --weather rain:10mm -o observed/",
    ),
    "streets": Command(
        _CLI + "pairs",
        "Make procedural streets: pairs of a scan and its condition image to train on.",
        "lidardraft streets -n 1000 --sensor hdl64e -o pairs/",
    ),
    "fit": Command(
        _CLI + "fit",
        "Get a sensor file fitted to your recorded scans: lasers, blocked pixels, noise, drop and intensity.",
        "lidardraft fit recordings/ --like os1-128 -o mine.json",
    ),
    "pairs": Command(
        _CLI + "pairs",
        "Make training pairs of your recorded scans: each scan, with the cast of its layout.",
        "lidardraft pairs recordings/ --sensor mine.json -o pairs/",
    ),
    "evaluate": Command(
        _CLI + "evaluate",
        "Score generated scans: those of weights on unseen streets, or folders of scans beside recordings by a "
        "published protocol.",
        "lidardraft evaluate --protocol lidm --real recordings/ --generated generated/",
    ),
    "doctor": Command(
        _CLI + "doctor",
        "Check this installation: version, caster, threads, torch and GPU, extras, and how to get missing parts.",
        "lidardraft doctor --json",
    ),
    "completion": Command(
        _CLI + "completion",
        "Print a script that completes commands and options in your shell.",
        "lidardraft completion bash > ~/.local/share/bash-completion/completions/lidardraft",
    ),
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line."""
    words = sys.argv[1:] if argv is None else argv
    return run(parser(words[:1]), words)


def parser(declared: Collection[str] = tuple(COMMANDS)) -> Parser:
    """The parser of the command line, with the options of the commands `declared`."""
    made = Parser(
        prog="lidardraft",
        description="Labelled LiDAR scans of your sensor, from a sentence, a layout of simple shapes, a 3D model or a "
        "labelled scan.",
        epilog=_FIRST,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument("--version", action="version", version=f"lidardraft {lidardraft.__version__}")
    add_commands(made, COMMANDS, declared)
    return made


if __name__ == "__main__":
    sys.exit(main())
