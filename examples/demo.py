"""A sentence becomes labelled LiDAR scans, simulated and generated: the paper's own example, in out/demo-generate/."""

import argparse
import time
from pathlib import Path

import numpy as np

import lidardraft
from lidardraft import view
from lidardraft.formats import kitti, semantickitti
from lidardraft.formats.boxes import write_boxes

SENTENCE = (
    "a vehicle driving on a road with vehicles both in front and behind, "
    "with trees and houses along both sides of the road"
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--text", default=SENTENCE)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("-o", "--output", type=Path, default=Path("out/demo-generate"))
    arguments = parser.parse_args()
    folder: Path = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()

    def say(text: str) -> None:
        print(f"[{time.perf_counter() - start:5.1f} s] {text}", flush=True)

    say(f"drafting: {arguments.text}")
    layout = lidardraft.surround(lidardraft.layout_from_text(arguments.text, seed=arguments.seed), seed=arguments.seed)
    layout.save(folder / "layout.json")
    say(f"{len(layout)} shapes, {len(layout.boxes())} objects with a box; simulating")
    sensor = lidardraft.Sensor.preset("hdl64e")
    simulated = lidardraft.simulate(layout, sensor, seed=arguments.seed)
    say(f"{len(simulated.points())} points; loading the generator")
    pipeline = lidardraft.Pipeline.from_pretrained("paper-small")  # "paper" takes six times as long
    say(f"generating in {pipeline.steps} steps")
    generated = pipeline(layout, sensor=sensor, seed=arguments.seed)
    for name, scan in (("simulated", simulated), ("generated", generated)):
        kitti.write_bin(folder / f"{name}.bin", scan.points(), scan.intensities())
        semantickitti.write_label(folder / f"{name}.label", scan.labels(), scan.instances())
    write_boxes(folder / "boxes.json", simulated.boxes(), simulated.returns_per_box())
    view.save_png(folder / "condition.png", view.render_image(generated.condition_image))
    images = {"condition image": generated.condition_image, "simulated": simulated.image, "generated": generated.image}
    pictures = [view.caption(view.render_layout(layout), "layout")]
    for name, image in images.items():
        pictures.append(view.caption(view.render_scan(image, generated.pose), name))
    view.save_png(folder / "preview.png", view.sheet(pictures))
    labelled = np.mean(generated.labels() > 0)
    say(f"{len(generated.points())} points, {labelled:.0%} of them labelled; look at {folder / 'preview.png'}")


if __name__ == "__main__":
    main()
