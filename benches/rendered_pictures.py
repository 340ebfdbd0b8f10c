"""Pictures of layouts as a pinhole camera sees them: colours, exact depth, classes, and what networks make of those."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.scene.layout import Layout
from lidardraft.scene.raycast import Raycaster
from lidardraft.view import PALETTE

SKY = (70, 130, 180)  # of the Cityscapes palette
KITTI = Pinhole(fx=721.5, fy=721.5, cx=609.6, cy=172.9, width=1242, height=375)
FURTHEST = 200.0  # m


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class RenderedPicture:
    """Pixels u8 [H, W, 3], depth along the axis f32 [H, W], classes and numbers of objects [H, W]; 0 is the sky."""

    camera: Pinhole
    pixels: np.ndarray
    depth: np.ndarray
    labels: np.ndarray
    instances: np.ndarray
    stand: dict[str, float]  # what `render` was given of the camera's height and tilt


def render(
    layout: Layout, camera: Pinhole = KITTI, *, height: float = 1.65, pitch: float = 0.0, roll: float = 0.0
) -> RenderedPicture:
    """What the camera sees from `height` [m] over the origin, looking along +x, `pitch` down and rolled [rad]."""
    (sp, cp), (sr, cr) = ((math.sin(a), math.cos(a)) for a in (pitch, roll))
    world_from_camera = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]) @ [[1, 0, 0], [0, cr, -sr], [0, sr, cr]]
    rows, columns = np.indices((camera.height, camera.width))
    rays = camera.rays(rows, columns).reshape(-1, 3)
    hits = Raycaster(layout).cast(np.array([0, 0, height]), rays @ world_from_camera.T, max_range=FURTHEST)
    shape = camera.height, camera.width
    light = np.array([0.4, 0.5, 0.77])
    shade = 0.55 + 0.45 * np.abs(hits.normal @ light)[:, None]
    pixels = np.where(hits.valid[:, None], PALETTE[hits.label] * shade, SKY).astype(np.uint8)
    return RenderedPicture(
        camera=camera,
        pixels=pixels.reshape(*shape, 3),
        depth=(hits.distance / np.linalg.norm(rays, axis=1)).reshape(shape).astype(np.float32),
        labels=hits.label.reshape(shape),
        instances=hits.instance.reshape(shape),
        stand={"height": height, "pitch": pitch, "roll": roll},
    )


def as_networks_give_it(picture: RenderedPicture, seed: int) -> RenderedPicture:
    """The picture with the errors of networks, in amounts that are estimates of ours.

    Depth 12 % too long, smooth over three pixels and in large patches 3 % off; vehicles and people a pixel too wide.
    """
    far = np.where(picture.depth > 0, picture.depth, 80.0)
    depth = depth_errors(far.shape, seed) * np.exp(ndimage.gaussian_filter(np.log(far), 1.0))
    grown = ndimage.grey_dilation(picture.labels * np.isin(picture.labels, range(11, 19)), 3)
    labels = np.where(grown > 0, grown, picture.labels)
    return replace(picture, depth=depth.astype(np.float32), labels=labels, instances=np.zeros_like(picture.instances))


def depth_errors(shape: tuple[int, ...], seed: int) -> np.ndarray:
    """What times the true depth [H, W] is that of networks: 1.12, in patches 3 % off."""
    patches = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=shape), 60)
    times: np.ndarray = 1.12 * (1 + 0.03 * (patches - patches.mean()) / patches.std())
    return times
