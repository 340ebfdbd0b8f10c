"""The card of a data set: its contents, for its readers."""

from __future__ import annotations

from typing import Any

from lidardraft.dataset.recipe import SCANS, Recipe
from lidardraft.semantics import BY_NAME

_RIDERS = (
    "A rider and the vehicle are one box of the class rider: `vehicle.bicycle` or `vehicle.motorcycle` with",
    "`cycle.with_rider` in nuScenes, Cyclist in KITTI.",
)
_TITLES = {"splits": "Splits", "sensors": "Sensors", "weather": "Weather", "scenes": "Scenes of the recipe"}


def card(recipe: Recipe, total: dict[str, Any]) -> str:
    """The text of README.md, from the counts of all shards."""
    scans = total["scans"]
    made = f"{scans // recipe.frames} drives of {recipe.frames} scans at {recipe.hz:g} Hz" if recipe.frames else scans
    lines = [
        f"# {recipe.format}: {made}{'' if recipe.frames else ' scans'}",
        "",
        f"Simulated by lidardraft from a recipe with the seed {recipe.seed} (recipe.json). Labels are those of the",
        "surfaces that returns came from; boxes are counted if they hold a return.",
        *(() if recipe.format == SCANS else _RIDERS),
    ]
    for key, title in _TITLES.items():
        lines += ["", f"| {title} | scans |", "|---|---|", *(f"| {name} | {n} |" for name, n in total[key].items())]
    points = sum(total["points"].values())
    lines += ["", "| Class | share of points | boxes | boxes a scan |", "|---|---|---|---|"]
    for name in (name for name in BY_NAME if name in total["points"] or name in total["boxes"]):
        boxes = total["boxes"].get(name, 0)
        counts = f"{boxes} | {boxes / scans:.2f}" if BY_NAME[name].is_thing else " | "
        lines.append(f"| {name} | {total['points'].get(name, 0) / points:.2%} | {counts} |")
    ranges = sorted(total["ranges"].items(), key=lambda row: int(row[0].split()[1]))  # "from 10 m"
    lines += ["", "| Boxes by distance | |", "|---|---|", *(f"| {name} | {n} |" for name, n in ranges)]
    return "\n".join(lines) + "\n"
