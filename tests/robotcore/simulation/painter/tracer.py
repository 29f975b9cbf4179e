"""A reference for the painter, which intersects the ray of each pixel with each body of the world."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from robotcore.description import Ball, WorldDescription
from robotcore.description.world import Prism
from robotcore.optics import CameraView

Array = NDArray[np.float64]


def trace_labels(world: WorldDescription, view: CameraView) -> NDArray[np.intp]:
    """Return for each pixel the number of the body that it shows, or 0. Prisms are numbered from 1 on, then balls."""
    return np.asarray(trace_depths(world, view).argmin(axis=0))


def trace_depths(world: WorldDescription, view: CameraView) -> Array:
    """Return the distance of each body on the ray of each pixel, (bodies + 1, height, width).

    The first distance is the maximum.
    """
    rays = compute_rays(view)
    depths = [_to_prism(prism, view.eye, rays) for prism in world.prisms]
    depths += [_to_ball(ball, view.eye, rays) for ball in world.targets]
    return np.stack([np.full(rays.shape[:2], np.finfo(float).max), *depths])


def compute_rays(view: CameraView) -> Array:
    """Return the direction of each pixel's ray in the world, (height, width, 3). Its depth is one focal length."""
    i = view.intrinsics
    u, v = np.meshgrid(np.arange(i.width) - i.cx, np.arange(i.height) - i.cy)
    return np.asarray(np.stack((u, v, np.full(u.shape, i.focal_length)), axis=-1) @ view.rotation)


def _to_prism(prism: Prism, eye: Array, rays: Array) -> Array:
    """The ray is inside the prism from the last half-space that it enters to the first one that it leaves."""
    enters, leaves = np.full(rays.shape[:2], -math.inf), np.full(rays.shape[:2], math.inf)
    outline = np.array(prism.outline)
    ways = np.roll(outline, -1, axis=0) - outline
    planes = [(np.array((w[1], -w[0], 0.0)), np.array((*p, 0.0))) for p, w in zip(outline, ways, strict=True)]
    up = np.array((0.0, 0.0, 1.0))
    planes += [(up, up * prism.height_m), (-up, np.zeros(3))]
    for normal, point in planes:
        slope, past = rays @ normal, float((eye - point) @ normal)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = -past / slope
        enters = np.where(slope < 0, np.maximum(enters, at), enters)
        leaves = np.where(slope > 0, np.minimum(leaves, at), leaves)
        leaves = np.where((slope == 0) & (past > 0), -math.inf, leaves)
    return np.where((enters <= leaves) & (enters > 0), enters, math.inf)


def _to_ball(ball: Ball, eye: Array, rays: Array) -> Array:
    centre = np.array((ball.x_m, ball.y_m, ball.radius_m)) - eye
    squared, along = (rays * rays).sum(axis=2), rays @ centre
    chord = along**2 - squared * float(centre @ centre - ball.radius_m**2)
    return np.where((chord >= 0) & (along > 0), (along - np.sqrt(np.maximum(chord, 0))) / squared, math.inf)


def roll(view: CameraView, angle: float) -> CameraView:
    """Return the view of a camera that is turned about its optical axis, by an angle in radians."""
    cos, sin = math.cos(angle), math.sin(angle)
    turn = np.array(((cos, sin, 0.0), (-sin, cos, 0.0), (0.0, 0.0, 1.0)))
    return replace(view, rotation=turn @ view.rotation)
