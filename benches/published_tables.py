"""The tables of the LiDARDraft paper, with a further row for each folder of scans.

    python benches/published_tables.py --real RECORDINGS --generated text=out/table/text full=out/ablation/scans/paper

Names of folders are rows of the paper (NAMES), or your own. `paper_table.py` and `ablation.py` make scans for them.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence

from lidardraft.cli.arguments import assignments
from lidardraft.cli.inputs import scan_files
from lidardraft.protocols import PROTOCOLS, Score, compare

Row = tuple[float, ...]  # FRD, MMD x 1e-4, JSD, FPD
NOT_KNOWN = math.nan

# Wei et al., LiDARDraft, Table 1: KITTI-360, 11,517 scans for evaluation.
INPUTS: dict[str, dict[str, Row]] = {
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
UNCONDITIONAL: dict[str, Row] = {
    "LiDARGen, 1160 steps": (129.0, 2.88, 0.188, 33.4),
    "LiDM, 50 steps": (125.1, 3.84, 0.211, 29.0),
}
# Table 2 of the paper.
ABLATION: dict[str, Row] = {
    "full": (23.01, 3.19, 0.077, NOT_KNOWN),
    "no-control": (54.76, 4.01, 0.323, NOT_KNOWN),
    "bird-eye": (123.66, 4.91, 0.429, NOT_KNOWN),
    "no-semantics": (28.98, 3.67, 0.122, NOT_KNOWN),
    "no-depth": (24.91, 3.40, 0.095, NOT_KNOWN),
}
NAMES = (*INPUTS, *ABLATION, "none")


def table_lines(ours: Mapping[str, list[Score]]) -> Iterator[str]:
    """The lines of the LiDARDraft paper's tables with a row for one of `ours`, scores by LiDM's protocol by name; then
    those of other names. Published rows are as published.

    The paper's MMD is LiDM's minimum matching distance. Its FRD and FPD most probably are LiDM's FRID and FPVD; FPVD
    needs a sparse network that is not rebuilt here.
    """
    one = {**INPUTS, "none": UNCONDITIONAL}
    two = {name: {"LiDARDraft": row} for name, row in ABLATION.items()}
    others: dict[str, dict[str, Row]] = {name: {} for name in ours if name not in NAMES}
    for title, tables in (("Table 1", one), ("Table 2", two), ("Not in the paper", others)):
        if ours.keys() & tables.keys():
            yield f"\n{title:44}{''.join(f'{name:>10}' for name in ('FRD', 'MMD e-4', 'JSD', 'FPD'))}"
            for name, published in tables.items():
                yield name
                rows = {f"{method} (published)": row for method, row in published.items()} | own_rows(ours.get(name))
                for what, row in rows.items():
                    shown = ("-" if math.isnan(value) else f"{value:.4g}" for value in row)
                    yield f"  {what:42}{''.join(f'{value:>10}' for value in shown)}"


def own_rows(scores: list[Score] | None) -> dict[str, Row]:
    """The row of scores, and that of their floors."""
    if scores is None:
        return {}
    metrics = [(scale, score) for metric, scale in (("FRID", 1.0), ("MMD", 1e4), ("JSD", 1.0))
               for score in scores if score.metric == metric]  # fmt: skip
    floors = (scale * max(score.floor, default=NOT_KNOWN) for scale, score in metrics)
    return {
        f"these {scores[0].generated} scans": (*(scale * score.value for scale, score in metrics), NOT_KNOWN),
        f"{scores[0].floor_scans} recorded scans beside others": (*floors, NOT_KNOWN),
    }


def main(argv: Sequence[str] | None = None) -> None:
    """Compare each folder by LiDM's protocol; print both tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--real", nargs="+", required=True, metavar="SCANS", help="recorded scans")
    parser.add_argument("--generated", nargs="+", required=True, metavar="NAME=FOLDER", help=f"{', '.join(NAMES)}, ...")
    parser.add_argument("--networks", metavar="FOLDER", help="folder of the public weights")
    arguments = parser.parse_args(argv)
    given = assignments(arguments.generated, "--generated", "NAME=FOLDER")
    recorded = scan_files(arguments.real)
    ours = {
        name: compare(PROTOCOLS["lidm"], recorded, scan_files([folder]), networks=arguments.networks)
        for name, folder in given.items()
    }
    print(f"by LiDM's metrics, {len(recorded)} recorded scans; (published): from other scans, by their authors' tools")
    for line in table_lines(ours):
        print(line)


if __name__ == "__main__":
    main()
