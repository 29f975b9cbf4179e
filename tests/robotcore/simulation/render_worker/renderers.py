"""Renderers that a render worker builds in its process."""

from __future__ import annotations

import os
import time

import numpy as np

from robotcore.description import Mount
from robotcore.geometry import Pose
from robotcore.optics import CameraView, Image, Intrinsics
from robotcore.simulation.rigid_body import ObjectIds

LENS = Intrinsics(32, 24, 1.0)
SLOW, HANGS, DIES = 500, 1000, 2000
"""The x of views at which `PlainRenderer` takes half a second, hangs, and ends its process."""


def build_view(x: float) -> CameraView:
    return CameraView.of(LENS, Mount(z_m=0.1), Pose(x, 0.0, 0.0))


class PlainRenderer:
    """Renders pictures of one grey level, the x of the view modulo 256."""

    things: dict[str, int] = {}  # noqa: RUF012  of the protocol

    def picture(self, view: CameraView) -> Image:
        x = int(view.eye[0])
        if x in (SLOW, HANGS):
            time.sleep(0.5 if x == SLOW else 60)
        if x == DIES:
            os._exit(1)
        return np.full((view.intrinsics.height, view.intrinsics.width, 3), x % 256, dtype=np.uint8)

    def segmentation(self, view: CameraView) -> ObjectIds:
        raise NotImplementedError


class BrokenRenderer(PlainRenderer):
    """A renderer that cannot be built."""

    def __init__(self) -> None:
        raise RuntimeError("no graphics today")
