"""A real labelled scan becomes a layout, and the layout another scan of the same place.

python examples/cloud_to_scan.py velodyne/000000.bin labels/000000.label -o out/cloud
"""

import argparse
from pathlib import Path

import lidardraft
from lidardraft import view
from lidardraft.formats import kitti, semantickitti
from lidardraft.metrics.adherence import adherence


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("points", help="a KITTI .bin scan")
    parser.add_argument("labels", help="its SemanticKITTI .label file")
    parser.add_argument("--sensor", default="hdl64e", help="the sensor that took it (default hdl64e)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("-o", "--output", type=Path, default=Path("out/cloud"))
    arguments = parser.parse_args()

    sensor = lidardraft.Sensor.preset(arguments.sensor)
    points, intensity = kitti.read_bin(arguments.points)
    label, instance = semantickitti.read_label(arguments.labels, len(points))
    layout = lidardraft.layout_from_cloud(points, label, instances=instance, sensor_height=sensor.mount_height)
    real = lidardraft.RangeImage.project(points, sensor, label=label, instance=instance, intensity=intensity)
    scan = lidardraft.simulate(layout, sensor, seed=arguments.seed)

    folder: Path = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    scan.save(folder / "000000")
    views = [
        view.caption(view.render_scan(image, scan.pose, by_label=True), name)
        for name, image in (
            ("real scan", real),
            ("condition image", scan.condition_image),
            ("simulated scan", scan.image),
        )
    ]
    images = [
        view.caption(view.render_image(image), name)
        for name, image in (("real scan", real), ("simulated scan", scan.image))
    ]
    view.save_png(
        folder / "comparison.png", view.stack([view.stack(views, across=True), view.stack(images, across=True)])
    )
    print(f"{len(points)} points became {len(layout)} shapes, {len(layout.boxes())} of them objects with a box")
    for name, image in (("real scan", real), ("simulated scan", scan.image)):
        print(
            f"{name}: {adherence(image, scan.condition_image).objects:.0%} of its returns on objects keep to the layout"
        )
    print(f"look at {folder / 'comparison.png'}")


if __name__ == "__main__":
    main()
