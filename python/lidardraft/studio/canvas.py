"""A visitor's view of a frame, in the 3D view of viser: `Canvas`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser

from lidardraft.scene.box import Box
from lidardraft.scene.layout import box_around
from lidardraft.scene.pose import point_at
from lidardraft.semantics import BY_NAME
from lidardraft.studio.frame import Frame, box_lines, meshes_of
from lidardraft.studio.session import Session
from lidardraft.view import PALETTE
from lidardraft.world.state import EGO_NAME

_LABELLED = 40  # boxes with a name over them, the nearest ones
_WHITE, _RED, _YELLOW, _GREY = (255, 255, 255), (255, 60, 60), (255, 220, 60), (150, 155, 170)
_GIZMO, _GIZMOS = 0.75, (1.6, 4.5)  # of the length of an object; m, the smallest and the largest
_GAMMA = 2.2  # of screens; viser ignores it for lines
Drag = Callable[[float, float, float, str], None]


class Canvas:
    """The nodes of one client's view. `drag` is called with x, y [m], yaw [rad] and the phase of a drag."""

    def __init__(self, client: viser.ClientHandle, drag: Drag) -> None:
        self._client, self._drag = client, drag
        self._nodes: dict[str, Any] = {}
        self._gizmo: tuple[str, viser.TransformControlsHandle] | None = None
        self._shown: dict[str, object] = {}
        self.camera, self.point_size = "Behind", 0.06
        self.see(None, None)

    def show(self, session: Session, frame: Frame) -> None:
        """Show the points, the ego vehicle and the selected object, all at once."""
        editor, selected = session.editor, session.selected
        ego = editor.box(EGO_NAME)
        with self._client.atomic():
            self._points("points", frame.points, frame.colours, self.point_size)
            self._lines("ego", [] if self.camera == "Seat" else [ego], _GREY)
            if selected is not None and selected in editor.world and frame.look.boxes:
                self._lines("selected", [editor.box(selected)], _WHITE, 3.0)
            else:
                self._remove("selected")
            if self.camera in ("Seat", "Above") and session.is_running:
                self.see(ego, None)

    def settle(self, session: Session, frame: Frame) -> None:
        """Show boxes, names, shapes, faults and the gizmo, which need not follow a drag."""
        look = frame.look
        boxes = frame.boxes() if look.boxes or look.labels else []
        others = [box for box in boxes if box.id.split(".")[0] != session.selected]
        wrong = {id for finding in session.findings() or () for id in finding.ids}
        with self._client.atomic():
            self._lines("boxes", others if look.boxes else [])
            faulty = [box_around([part]) for part in frame.layout if part.id in wrong]
            self._lines("faults", faulty if look.boxes else [], _RED, 3.0)
            self._labels(boxes if look.labels else [])
            shapes = (frame.layout, look.hidden) if look.layout else None
            if self._shown.get("layout") != shapes:
                self._meshes(meshes_of(*shapes) if shapes else {})
                self._shown["layout"] = shapes
            recorded = session.recorded if look.recorded else session.recorded[:0]
            if self._shown.get("recorded") is not recorded:
                self._points("recorded", recorded, np.full(recorded.shape, 150, np.uint8), 0.05)
                self._shown["recorded"] = recorded
            self._place_gizmo(session, session.selected)

    def see(self, ego: Box | None, target: Box | None) -> None:
        """Set the camera by `camera`: on a target, from the seat of the ego vehicle, above it or behind it."""
        x, y, yaw = (*ego.center[:2], ego.yaw) if ego else (0.0, 0.0, 0.0)
        camera = self._client.camera
        if target is not None:
            (x, y, z), away = target.center, 6.0 + 2.0 * max(target.size)
            eye, at = (x - 0.7 * away, y - 0.5 * away, z + 0.6 * away), (x, y, z)
        elif self.camera == "Seat":
            eye, at = (*point_at((x, y, yaw), -0.2, 0.35), 1.25), (*point_at((x, y, yaw), 20.0, 0.35), 0.9)
        elif self.camera == "Both":
            eye, at = (*point_at((x, y, yaw), -48.0, -35.0), 42.0), (*point_at((x, y, yaw), 8.0, -35.0), 0.0)
        elif self.camera == "Above":
            eye, at = (*point_at((x, y, yaw), -0.5, 0.0), 75.0), (x, y, 0.0)
        else:
            eye, at = (*point_at((x, y, yaw), -22.0, -11.0), 13.0), (*point_at((x, y, yaw), 7.0, 0.0), 0.0)
        camera.position, camera.look_at = eye, at

    def _points(self, name: str, points: np.ndarray, colours: np.ndarray, size: float) -> None:
        node = self._nodes.get(name)
        if not len(points):  # viser cannot draw none
            self._remove(name)
        elif node is None:
            self._nodes[name] = self._client.scene.add_point_cloud(
                f"/{name}", points, colours, point_size=size, point_shape="circle", precision="float32",
                point_shading="flat",
            )  # fmt: skip
        else:
            node.points, node.colors = points, colours
            node.point_size = size

    def _lines(
        self, name: str, boxes: Sequence[Box], colour: tuple[int, int, int] | None = None, wide: float = 1.5
    ) -> None:
        if not boxes:
            self._remove(name)
            return
        lines, colours = box_lines(boxes)
        if colour is not None:
            colours[:] = colour
        colours = (255 * (colours / 255) ** _GAMMA).astype(np.uint8)  # viser draws lines brighter than points
        node = self._nodes.get(name)
        if node is not None:
            node.points, node.colors = lines, colours
        else:
            self._nodes[name] = self._client.scene.add_line_segments(
                f"/{name}", lines, colours, thickness=wide, thickness_units="screen"
            )

    def _remove(self, name: str) -> None:
        if (node := self._nodes.pop(name, None)) is not None:
            node.remove()

    def _labels(self, boxes: Sequence[Box]) -> None:
        near = sorted(boxes, key=lambda box: math.hypot(*box.center[:2]))[:_LABELLED]
        wanted = {f"label/{box.id}": box for box in near}
        for name in [name for name in self._nodes if name.startswith("label/") and name not in wanted]:
            self._remove(name)
        for name, box in wanted.items():
            place = (*box.center[:2], box.center[2] + box.size[2] / 2 + 0.4)
            if name in self._nodes:
                self._nodes[name].position = place
            else:
                self._nodes[name] = self._client.scene.add_label(
                    f"/{name}", box.id.split(".")[0], position=place, anchor="bottom-center", font_screen_scale=0.8
                )

    def _meshes(self, meshes: dict[str, tuple[np.ndarray, np.ndarray]]) -> None:
        for name in [name for name in self._nodes if name.startswith("mesh/")]:
            self._remove(name)
        for label, (vertices, faces) in meshes.items():
            self._nodes[f"mesh/{label}"] = self._client.scene.add_mesh_simple(
                f"/mesh/{label}", vertices, faces, color=tuple(PALETTE[BY_NAME[label].id].tolist()), opacity=0.45,
                flat_shading=True, side="double", cast_shadow=False, receive_shadow=False,
            )  # fmt: skip

    def _place_gizmo(self, session: Session, name: str | None) -> None:
        """Place arrows and an arc at the feet of the selected object."""
        if self._gizmo is not None and self._gizmo[0] != name:
            self._gizmo[1].remove()
            self._gizmo = None
        if name is None or name not in session.editor.world:
            return
        box = session.editor.box(name)
        place, turn = (*box.center[:2], box.center[2] - box.size[2] / 2 + 0.3), _quaternion(box.yaw)
        if self._gizmo is None:
            gizmo = self._client.scene.add_transform_controls(
                "/gizmo", scale=float(np.clip(_GIZMO * max(box.size[:2]), *_GIZMOS)), active_axes=(True, True, False),
                depth_test=False, position=place, wxyz=turn,
            )  # fmt: skip
            self._gizmo = name, gizmo

            async def dragged(event: Any) -> None:  # async keeps the order; threads would not
                x, y, _ = event.target.position.tolist()
                w, _, _, z = event.target.wxyz.tolist()
                self._drag(x, y, 2.0 * math.atan2(z, w), event.phase)

            gizmo.on_update(dragged)
        else:
            self._gizmo[1].position, self._gizmo[1].wxyz = place, turn


def _quaternion(yaw: float) -> tuple[float, float, float, float]:
    return math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)
