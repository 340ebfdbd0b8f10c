"""The tables of the LiDARDraft paper, as published, with rows for the scores of other scans.

The scores are LiDM's: the paper's MMD is LiDM's minimum matching distance, and its FRD and FPD most probably are LiDM's
FRID and FPVD; FPVD needs a sparse network that is not rebuilt here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from lidardraft.protocols import Score

Row = tuple[float, ...]  # FRD, MMD x 1e-4, JSD, FPD
_METRICS = ("FRD", "MMD e-4", "JSD", "FPD")
_NOT_KNOWN = math.nan

# Wei et al., LiDARDraft, Table 1: KITTI-360, 11,517 scans for evaluation.
_INPUTS: dict[str, dict[str, Row]] = {
    "map": {
        "latent diffusion": (24.21, 3.31, 0.088, 20.60),
        "LiDM": (22.93, 3.16, 0.072, 18.50),
        "LiDARDraft": (21.72, 3.14, 0.070, 18.32),
    },
    "text": {
        "LiDM": (80.61, 4.74, 0.415, 29.60),
        "Text2LiDAR": (170.12, 5.12, 0.439, 34.81),
        "LiDARDraft": (23.88, 3.23, 0.079, 19.11),
    },
    "image": {
        "latent diffusion": (50.50, 3.99, 0.314, 26.51),
        "LiDM": (45.14, 3.72, 0.256, 25.83),
        "LiDARDraft": (24.62, 3.39, 0.094, 21.32),
    },
    "cloud": {
        "latent diffusion": (129.90, 4.99, 0.434, 32.98),
        "LiDM": (121.50, 4.82, 0.423, 31.77),
        "LiDARDraft": (27.98, 3.43, 0.099, 22.12),
    },
}
# hancyran/LiDAR-Diffusion, README: KITTI-360 without a condition, 2,000 scans beside those of drive 03.
_UNCONDITIONAL: dict[str, Row] = {
    "LiDARGen, 1160 steps": (129.0, 2.88, 0.188, 33.4),
    "LiDM, 50 steps": (125.1, 3.84, 0.211, 29.0),
}
# Table 2 of the paper.
_ABLATION: dict[str, Row] = {
    "full": (23.01, 3.19, 0.077, _NOT_KNOWN),
    "no-control": (54.76, 4.01, 0.323, _NOT_KNOWN),
    "bird-eye": (123.66, 4.91, 0.429, _NOT_KNOWN),
    "no-semantics": (28.98, 3.67, 0.122, _NOT_KNOWN),
    "no-depth": (24.91, 3.40, 0.095, _NOT_KNOWN),
}
NAMES = (*_INPUTS, *_ABLATION, "none")


def table_lines(ours: Mapping[str, list[Score]]) -> Iterator[str]:
    """The lines of the tables in which a row of `ours`, scores by name, belongs; then those of other names."""
    if ours.keys() & {*_INPUTS, "none"}:
        yield _heading("Table 1")
        for name, published in (*_INPUTS.items(), ("none", _UNCONDITIONAL)):
            yield from _rows(name, published, ours.get(name))
    if ours.keys() & _ABLATION.keys():
        yield _heading("Table 2")
        for name, row in _ABLATION.items():
            yield from _rows(name, {"LiDARDraft": row}, ours.get(name))
    if others := [name for name in ours if name not in NAMES]:
        yield _heading("Not in the paper")
        for name in others:
            yield from _rows(name, {}, ours[name])


def _heading(title: str) -> str:
    return f"\n{title:44}{''.join(f'{name:>10}' for name in _METRICS)}"


def _rows(name: str, published: Mapping[str, Row], scores: list[Score] | None) -> Iterator[str]:
    yield name
    for method, row in published.items():
        yield _line(f"  {method} (published)", row)
    if scores is None:
        return
    values = {score.metric: score for score in scores}
    metrics = (("FRID", 1.0), ("MMD", 1e4), ("JSD", 1.0))
    found = (scale * values[metric].value for metric, scale in metrics)
    yield _line(f"  these {scores[0].generated} scans", (*found, _NOT_KNOWN))
    floors = (scale * max(values[metric].floor, default=_NOT_KNOWN) for metric, scale in metrics)
    yield _line(f"  {scores[0].floor_scans} recorded scans beside others", (*floors, _NOT_KNOWN))


def _line(name: str, row: Row) -> str:
    shown = ("-" if math.isnan(value) else f"{value:.4g}" for value in row)
    return f"{name:44}{''.join(f'{value:>10}' for value in shown)}"
