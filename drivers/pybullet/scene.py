"""The world in Bullet: a floor, fixed prisms and balls, and a light."""

from __future__ import annotations

from enum import IntFlag
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2

from drivers.pybullet.bullet import Bullet
from robotcore.description import Ball, Floor, Texture, WorldDescription
from robotcore.description.meshes import Mesh, ball_mesh, ground_mesh, prism_mesh, sheet_mesh
from robotcore.description.world import Prism
from robotcore.optics import Image
from robotcore.simulation.floor_sheet import FloorSheet, draw_floor_sheet

GROUND_HALF_M = 200.0
"""Half the width of the drawn ground, in metres. Its edge appears less than a pixel below the horizon."""

ORIGIN = (0.0, 0.0, 0.0)
WHITE = (255, 255, 255)
"""The colour of a body whose texture has the colours."""

NO_SHAPE = -1
"""Bullet's number for the collision shape of a body that collides with nothing."""

HULL_MARGIN_M = 1e-6
"""The collision margin around a prism, in metres. Rays would miss a prism without margin. Bullet's default is 1 mm."""


class CollisionGroup(IntFlag):
    """The collision groups of bodies, as bits. The group of Bullet's rays is 1."""

    RAY = 1
    FLOOR = 64
    THING = 128
    BODY = 256
    WHEEL = 512


class BulletScene:
    """The floor, the things and the light of a world in Bullet."""

    def __init__(self, bullet: Bullet, world: WorldDescription, *, has_sheet: bool = True) -> None:
        """Add the world to Bullet.

        has_sheet: whether to add the lines and the picture on the floor. Only cameras and windows need them.
        """
        self._bullet = bullet
        self._textures = Textures(bullet)
        self.light = world.light
        """The light that cameras render pictures with."""
        prisms = {prism.name: self._add_prism(prism) for prism in world.prisms}
        balls = {ball.name: self._add_ball(ball) for ball in world.targets}
        self.things = prisms | balls
        """Bullet's ids of the things by name, without the floor."""
        self._add_floor(world.floor, draw_floor_sheet(world) if has_sheet else None)

    def _add_floor(self, floor: Floor, sheet: FloorSheet | None) -> None:
        """Add the floor as the last body. Bullet then does not draw the pixels of the floor that other bodies hide."""
        bullet = self._bullet
        plane = bullet.createCollisionShape(bullet.GEOM_PLANE)
        ground = ground_mesh(GROUND_HALF_M, floor, sheet.hole if sheet else None)
        body = self._add(plane, ground, floor.colour, ORIGIN)
        self._apply_texture(body, floor.texture)
        bullet.changeDynamics(body, -1, lateralFriction=1.0)
        bullet.setCollisionFilterGroupMask(body, -1, CollisionGroup.FLOOR, CollisionGroup.BODY | CollisionGroup.WHEEL)
        if sheet:
            drawn = self._add(NO_SHAPE, sheet_mesh(sheet.rectangle), WHITE, ORIGIN)
            texture = _load_picture(bullet, sheet.pixels[::-1, :, ::-1])
            bullet.changeVisualShape(drawn, -1, textureUniqueId=texture)

    def _add_prism(self, prism: Prism) -> int:
        bullet = self._bullet
        mesh = prism_mesh(prism)
        hull = bullet.createCollisionShape(bullet.GEOM_MESH, vertices=mesh.vertices)
        body = self._add(hull, mesh, prism.colour, (prism.x_m, prism.y_m, 0.0), prism.yaw_rad)
        bullet.changeDynamics(body, -1, collisionMargin=HULL_MARGIN_M)
        self._apply_texture(body, prism.texture)
        return self._make_detectable(body)

    def _add_ball(self, ball: Ball) -> int:
        bullet = self._bullet
        sphere = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=ball.radius_m)
        place = (ball.x_m, ball.y_m, ball.radius_m)
        return self._make_detectable(self._add(sphere, ball_mesh(ball.radius_m), ball.colour, place))

    def _apply_texture(self, body: int, texture: Texture | None) -> None:
        if texture:
            self._bullet.changeVisualShape(body, -1, textureUniqueId=self._textures.find_or_load(texture))

    def _make_detectable(self, body: int) -> int:
        self._bullet.setCollisionFilterGroupMask(
            body, -1, CollisionGroup.THING, CollisionGroup.BODY | CollisionGroup.RAY
        )
        return body

    def _add(
        self,
        collision: int,
        mesh: Mesh,
        colour: tuple[int, int, int],
        place: tuple[float, float, float],
        yaw: float = 0.0,
    ) -> int:
        bullet = self._bullet
        visual = bullet.createVisualShape(
            bullet.GEOM_MESH,
            vertices=mesh.vertices,
            normals=mesh.normals,
            indices=mesh.indices,
            uvs=mesh.uvs,
            rgbaColor=[*(part / 255 for part in colour), 1.0],
            specularColor=[0.0, 0.0, 0.0],
        )
        facing = bullet.getQuaternionFromEuler([0.0, 0.0, yaw])
        body: int = bullet.createMultiBody(0.0, collision, visual, place, facing)
        return body


class Textures:
    """The textures of a world. Each is loaded into Bullet once."""

    def __init__(self, bullet: Bullet) -> None:
        self._bullet = bullet
        self._ids: dict[Texture, int] = {}

    def find_or_load(self, texture: Texture) -> int:
        """Return Bullet's id of a texture. Loads the texture if Bullet does not have it."""
        if texture not in self._ids:
            self._ids[texture] = _load_picture(self._bullet, texture.tile[::-1])
        return self._ids[texture]


def _load_picture(bullet: Bullet, picture: Image) -> int:
    """Load a picture as a texture, and return Bullet's id. Its top row is the highest on the surface."""
    with TemporaryDirectory() as folder:
        file = Path(folder, "picture.png")
        cv2.imwrite(str(file), picture)
        number: int = bullet.loadTexture(str(file))
    return number
