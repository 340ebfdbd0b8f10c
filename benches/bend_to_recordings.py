"""Does a network that has seen some recordings make simulated scans of other sensors more like theirs?

    python benches/bend_to_recordings.py [--data FOLDER] [--steps 600]

Labelled recordings of each sensor become layouts and these simulated scans, as in `report_simulate.py`. A small network
learns, from the sets of a free licence alone, what a recording reads where a simulated scan and the recording agree,
and which of its returns the recording lost. It then draws the intensities and drops of sets that it has not seen.
Beside it stand the simulated scan, untrained weights of the same form, which pass the simulated scan through, and
**a table**: the readings of each class, mapped so that those of the recordings it has seen come out. "this sensor's
table" has seen other drives, or another part of the drive, of the sensor that is judged: what calibration reaches.
Intensity: mean distance (JSD) over the classes. AUC: of a classifier that tells made from recorded, as in
`report_two_sample.py`.
"""

from __future__ import annotations

import argparse
import itertools
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

import markdown_table
from cases import recorded_sets, sweeps_of
from lidardraft.metrics import lifelike
from lidardraft.metrics.lifelike import CLASS_SETS
from lidardraft.metrics.sweep import Sweep
from lidardraft.metrics.two_sample import two_sample
from lidardraft.scene.labelling import ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE
from lidardraft.semantics import BY_NAME, NUM_CLASSES

FREE = ("PandaSet, Pandar64", "ika, VLP-32C")  # sets that a network may learn from
LEVELS = 48  # of the root of the intensity
BLUR = 1.5  # levels: how surely untrained weights keep the simulated intensity
DROP_PRIOR = -8.0  # logit
LEARNING_RATE = 1e-2
OCTAVES = 5  # of the waves by which a network sees intensity
FEWEST = 500  # returns of a class that has a distance
SET_OF = np.zeros(NUM_CLASSES, int)
for _number, _members in enumerate(CLASS_SETS.values(), 1):
    SET_OF[[BY_NAME[name].id for name in _members]] = _number
INTENSITIES = [one for one in lifelike.class_properties() if one.name.startswith("intensity") and "JSD" in one.name]
DROPS = next(one for one in lifelike.PROPERTIES if one.name.startswith("runs of dropped"))

Bend = Callable[[Sweep, int], Sweep]
Learn = Callable[[Sequence["Example"]], Bend]


@dataclass(frozen=True, eq=False)
class Example:
    """A recorded sweep, the simulated one of its layout, and whether rays that return nothing are known as dropped."""

    recorded: Sweep
    simulated: Sweep
    firings: bool

    @property
    def agree(self) -> np.ndarray:
        """Where both return from the same surface of the same class, bool [H, W]."""
        near = np.abs(self.simulated.depth - self.recorded.depth)
        near = near <= np.maximum(ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE * self.recorded.depth)
        same = SET_OF[self.simulated.label] == SET_OF[self.recorded.label]
        found: np.ndarray = self.recorded.valid & self.simulated.valid & near & same
        return found


def level(intensity: np.ndarray) -> np.ndarray:
    """The level of each intensity, 0 to LEVELS - 1."""
    found: np.ndarray = np.clip(np.sqrt(intensity) * LEVELS, 0, LEVELS - 1).astype(np.int64)
    return found


class Network(nn.Module):
    """Logits [B, LEVELS + 1, H, W] of what is read and whether it is lost; untrained, those of the simulated scan."""

    def __init__(self, width: int = 32) -> None:
        super().__init__()
        channels = [len(CLASS_SETS) + 5 + 2 * OCTAVES, width, width, width]
        layers: list[nn.Module] = []
        for before, after in itertools.pairwise(channels):
            layers += [nn.Conv2d(before, after, 3, padding=1, padding_mode="replicate"), nn.SiLU()]
        self.body = nn.Sequential(*layers)
        self.head = nn.Conv2d(width, LEVELS + 1, 1)
        nn.init.zeros_(self.head.weight)
        nn.init.zeros_(self.head.bias)  # type: ignore[arg-type]

    def forward(self, seen: Tensor, levels: Tensor) -> Tensor:
        kept = -(((torch.arange(LEVELS)[:, None, None] - levels[:, None]) / BLUR) ** 2) / 2
        prior = torch.cat([kept, torch.full_like(kept[:, :1], DROP_PRIOR)], dim=1)
        return prior + self.head(self.body(seen))


def seen_of(sweep: Sweep) -> tuple[Tensor, Tensor]:
    """What the network sees of a simulated sweep, [1, C, H, W], and its levels [1, H, W]."""
    assert sweep.label is not None
    assert sweep.intensity is not None
    classes = np.eye(len(CLASS_SETS) + 1, dtype=np.float32)[SET_OF[sweep.label] * sweep.valid]
    range_, height = np.log1p(sweep.depth) / 4, sweep.points[..., 2] / 4
    root = np.sqrt(sweep.intensity)
    waves = [wave(math.pi * 2**octave * root) for octave in range(OCTAVES) for wave in (np.sin, np.cos)]
    channels = [sweep.valid, range_, height, root, *waves]
    seen = np.concatenate([np.stack(channels), classes.transpose(2, 0, 1)]).astype(np.float32)
    return torch.from_numpy(seen)[None], torch.from_numpy(level(sweep.intensity))[None]


def trained(examples: Sequence[Example], steps: int) -> Network:
    """A network that has seen the examples, 256 columns a step."""
    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    network = Network()
    optimiser = torch.optim.AdamW(network.parameters(), lr=LEARNING_RATE)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, LEARNING_RATE, total_steps=steps)
    for _ in range(steps):
        example = examples[rng.integers(len(examples))]
        start = int(rng.integers(max(1, example.recorded.points.shape[1] - 256)))
        part = Example(*(s.part(start, start + 256) for s in (example.recorded, example.simulated)), example.firings)
        logits = network(*seen_of(part.simulated))[0]
        agree = torch.from_numpy(part.agree)
        loss = torch.zeros(())
        if agree.any():
            assert part.recorded.intensity is not None
            read = torch.from_numpy(level(part.recorded.intensity))
            loss = loss + nn.functional.cross_entropy(logits[:LEVELS, agree].T, read[agree])
        returned = torch.from_numpy(part.simulated.valid)
        if part.firings and returned.any():
            lost = torch.from_numpy(~part.recorded.valid).float()
            loss = loss + nn.functional.binary_cross_entropy_with_logits(logits[LEVELS, returned], lost[returned])
        if loss.requires_grad:
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
        schedule.step()
    return network


def by_network(network: Network) -> Bend:
    """Intensities and drops drawn from what a network says."""

    @torch.no_grad()
    def bend(sweep: Sweep, seed: int) -> Sweep:
        rng = np.random.default_rng(seed)
        logits = network(*seen_of(sweep))[0]
        shares = torch.softmax(logits[:LEVELS], dim=0).cumsum(dim=0).numpy()
        drawn = (shares < rng.random(sweep.depth.shape)).sum(axis=0) + rng.random(sweep.depth.shape)
        kept = rng.random(sweep.depth.shape) >= torch.sigmoid(logits[LEVELS]).numpy()
        points = np.where(kept[..., None], sweep.points, np.float32(0))
        return replace(sweep, points=points, intensity=np.float32(np.minimum(drawn / LEVELS, 1.0) ** 2))

    return bend


def by_table(examples: Sequence[Example]) -> Bend:
    """Quantiles of the simulated readings of each class become those of the recorded ones."""
    shares = np.linspace(0, 1, 101)
    maps = {}
    for number in range(1, len(CLASS_SETS) + 1):
        values: dict[str, list[np.ndarray]] = {"simulated": [], "recorded": []}
        for example in examples:
            here = example.agree & (SET_OF[example.recorded.label] == number)
            for name, found in values.items():
                found.append(getattr(example, name).intensity[here])
        if sum(map(len, values["recorded"])) >= FEWEST:
            maps[number] = [np.quantile(np.concatenate(found), shares) for found in values.values()]

    def bend(sweep: Sweep, seed: int) -> Sweep:
        assert sweep.intensity is not None
        rng = np.random.default_rng(seed)
        intensity = sweep.intensity.copy()
        for number, (simulated, recorded) in maps.items():
            here = SET_OF[sweep.label] == number
            dithered = intensity[here] + rng.uniform(-0.5, 0.5, here.sum()) / 255  # equal readings spread
            intensity[here] = np.interp(dithered, simulated + np.arange(101) * 1e-9, recorded)
        return replace(sweep, intensity=intensity)

    return bend


def scores(examples: Sequence[Example], bend: Bend | None) -> dict[str, float]:
    """How far the bent simulated scans of a set are from the recorded ones."""
    made = [e.simulated if bend is None else bend(e.simulated, number) for number, e in enumerate(examples)]
    recorded = [example.recorded for example in examples]
    counts = [sum(int((SET_OF[s.label] == n)[s.valid].sum()) for s in recorded) for n in range(len(CLASS_SETS) + 1)]
    chosen = [one for one, count in zip(INTENSITIES, counts[1:], strict=True) if count >= FEWEST]
    distances = [one.distance([one.measure(s) for s in recorded], [one.measure(s) for s in made]) for one in chosen]
    found = {"intensity": float(np.mean(distances))}
    if examples[0].firings:
        found["drop runs"] = DROPS.distance(*([DROPS.measure(s) for s in sweeps] for sweeps in (recorded, made)))
    half = len(recorded) // 2
    auc = two_sample({"first": recorded[:half], "second": recorded[half:]}, made).auc
    told = {family: auc[family] for family in ("intensity", "drop") if family in auc}
    return found | {f"AUC {family}": value for family, value in told.items() if value != 0.5}  # of too few crops


def report(sets: Mapping[str, Sequence[Example]], steps: int) -> dict[str, markdown_table.Row]:
    """A row for each set and way of bending."""
    table: dict[str, markdown_table.Row] = {}
    ways: dict[str, Learn] = {
        "network": lambda examples: by_network(trained(examples, steps)),
        "table": by_table,
    }
    for name, examples in sets.items():
        others = [example for other in FREE if other != name for example in sets.get(other, ())]
        halves = examples[: len(examples) // 2], examples[len(examples) // 2 :]
        table[f"{name}: simulated"] = scores(examples, None)
        table[f"{name}: untrained"] = scores(examples, by_network(Network()))
        for way, learn in ways.items():
            if others:
                table[f"{name}: {way}"] = scores(examples, learn(others))
            found = [scores(tested, learn(seen)) for tested, seen in (halves, halves[::-1])]
            table[f"{name}: this sensor's {way}"] = {
                key: float(np.mean([row[key] for row in found])) for key in found[0]
            }
    return table


def examples_of(folder: Path) -> dict[str, list[Example]]:
    """The labelled recordings in a folder, with the simulated scans of their layouts."""
    found = {}
    for name, make in recorded_sets(folder):
        cases = make()
        found[name] = [Example(s["recorded"], s["simulated"], cases.firings) for s in sweeps_of(cases)]
    return {name: examples for name, examples in found.items() if len(examples) >= 4}


def main() -> None:
    """Parse, learn, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("LIDARDRAFT_DATA", "")), help="recordings")
    parser.add_argument("--steps", type=int, default=600, help="steps that a network learns")
    given = parser.parse_args()
    examples = examples_of(given.data) if given.data.name else {}
    if not examples:
        print("Skipped: no labelled recordings; name their folder in LIDARDRAFT_DATA or --data.")
        return
    print(markdown_table.table(report(examples, given.steps)))


if __name__ == "__main__":
    main()
