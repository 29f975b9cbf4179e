"""The world in the MuJoCo model: a floor, fixed prisms and balls, a light and a sky."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drivers.mujoco.model.attributes import CollisionGroup, Colour, RenderGroup, rgba, rotation_about_z
from robotcore.description import Ball, Box, Floor, Light, Texture, WorldDescription
from robotcore.description.meshes import Mesh, ground_mesh, prism_mesh, sheet_mesh
from robotcore.description.png import Pixels
from robotcore.description.world import Prism
from robotcore.simulation.floor_sheet import FloorSheet, draw_floor_sheet

if TYPE_CHECKING:
    from mujoco import MjSpec


GROUND_HALF_M = 200.0
"""Half the width of the drawn ground, in metres. Its edge appears less than a pixel below the horizon."""

GROUND = "Ground"
"""The name of the floor in the model. No thing has this name, because the names of things are in lower case."""

SHEET = "Sheet"
"""The name of the sheet with the lines and the picture on the floor, in the model."""

WHITE = (255, 255, 255)
"""The colour of a material whose texture has the colours."""

BALL_SLICES, BALL_STACKS = 64, 32
"""The numbers of slices and stacks of a drawn sphere. The outline covers 99.8 % of a circle's area."""


def visual_name(thing: str) -> str:
    """Return the name of the visual geom of a thing. The collision geom has the name of the thing itself."""
    return f"{thing}.seen"


def add_world(spec: MjSpec, world: WorldDescription, *, has_sheet: bool) -> None:
    """Add the light, the sky, the floor and all things of a world to the model.

    has_sheet: whether to add the lines and the picture on the floor. Only cameras and windows need them.
    """
    materials = Materials(spec)
    _add_light(spec, world.light)
    materials.add_sky(world.light.sky_colour)
    _add_floor(spec, world.floor, draw_floor_sheet(world) if has_sheet else None, materials)
    for prism in world.prisms:
        _add_prism(spec, prism, materials)
    for ball in world.targets:
        _add_ball(spec, ball, materials)
    spec.visual.quality.numslices, spec.visual.quality.numstacks = BALL_SLICES, BALL_STACKS


def _add_light(spec: MjSpec, light: Light) -> None:
    import mujoco

    ambient, diffuse = light.ambient * light.brightness, light.diffuse * light.brightness
    headlight = spec.visual.headlight
    headlight.ambient, headlight.diffuse, headlight.specular = [ambient] * 3, [0.0] * 3, [0.0] * 3
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        dir=[-part for part in light.direction],
        diffuse=[diffuse] * 3,
        ambient=[0.0] * 3,
        specular=[0.0] * 3,
        castshadow=False,
    )


def _add_floor(spec: MjSpec, floor: Floor, sheet: FloorSheet | None, materials: Materials) -> None:
    import mujoco

    spec.worldbody.add_geom(
        name=GROUND,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, 0.0, 1.0],
        contype=CollisionGroup.FLOOR,
        conaffinity=CollisionGroup.NOTHING,
        friction=[1.0, 0.0, 0.0],
        group=RenderGroup.ROBOT_COLLISION,
    )
    _add_visual_mesh(
        spec,
        GROUND,
        ground_mesh(GROUND_HALF_M, floor, sheet.hole if sheet else None),
        materials.find_or_add(floor.colour, floor.texture),
        RenderGroup.FLOOR,
    )
    if sheet:
        material = materials.add_sheet(sheet.pixels)
        _add_visual_mesh(spec, SHEET, sheet_mesh(sheet.rectangle), material, RenderGroup.FLOOR)


def _add_prism(spec: MjSpec, prism: Prism, materials: Materials) -> None:
    import mujoco

    mesh = prism_mesh(prism)
    place = {"pos": [prism.x_m, prism.y_m, 0.0], "quat": rotation_about_z(prism.yaw_rad)}
    _add_visual_mesh(
        spec, prism.name, mesh, materials.find_or_add(prism.colour, prism.texture), RenderGroup.WORLD, **place
    )
    collision = {
        "contype": CollisionGroup.THING,
        "conaffinity": CollisionGroup.NOTHING,
        "group": RenderGroup.THING_COLLISION,
        "name": prism.name,
    }
    if isinstance(prism, Box):
        half = prism.height_m / 2
        size = [prism.length_m / 2, prism.width_m / 2, half]
        middle = {**place, "pos": [prism.x_m, prism.y_m, half]}
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, **middle, **collision)
    else:
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=_mesh_name(prism.name), **place, **collision)


def _add_ball(spec: MjSpec, ball: Ball, materials: Materials) -> None:
    import mujoco

    sphere = {
        "type": mujoco.mjtGeom.mjGEOM_SPHERE,
        "size": [ball.radius_m, 0.0, 0.0],
        "pos": [ball.x_m, ball.y_m, ball.radius_m],
        "conaffinity": CollisionGroup.NOTHING,
    }
    visual = {
        "contype": CollisionGroup.NOTHING,
        "group": RenderGroup.WORLD,
        "material": materials.find_or_add(ball.colour, None),
    }
    spec.worldbody.add_geom(name=visual_name(ball.name), **sphere, **visual)
    spec.worldbody.add_geom(name=ball.name, **sphere, contype=CollisionGroup.THING, group=RenderGroup.THING_COLLISION)


def _add_visual_mesh(spec: MjSpec, name: str, mesh: Mesh, material: str, group: RenderGroup, **place: Any) -> None:
    """Add a visual geom with the shape of a mesh.

    name: the name of the thing.
    material: the name of a material in the model.
    place: the position and the orientation, as attributes of the geom.
    """
    import mujoco

    model_mesh = spec.add_mesh(name=_mesh_name(name))
    model_mesh.uservert = [part for vertex in mesh.vertices for part in vertex]
    model_mesh.usernormal = [part for normal in mesh.normals for part in normal]
    model_mesh.userface = mesh.indices
    if mesh.uvs:
        model_mesh.usertexcoord = [part for uv in mesh.uvs for part in uv]
    model_mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.worldbody.add_geom(
        name=visual_name(name),
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=model_mesh.name,
        material=material,
        contype=CollisionGroup.NOTHING,
        conaffinity=CollisionGroup.NOTHING,
        group=group,
        **place,
    )


def _mesh_name(thing: str) -> str:
    return f"{thing}_mesh"


class Materials:
    """The materials of a model, each added once. They are matt: a face's brightness is its colour times the light."""

    def __init__(self, spec: MjSpec) -> None:
        self._spec = spec
        self._names: dict[tuple[Colour, Texture | None], str] = {}
        self._textures: dict[Texture, str] = {}

    def find_or_add(self, colour: Colour, texture: Texture | None) -> str:
        """Return the name of the material with a colour and a texture. Adds the material if the model does not have it.

        texture: the texture, which darkens the colour; None for a plain colour.
        """
        key = (colour, texture)
        if key not in self._names:
            self._names[key] = name = f"look_{len(self._names)}"
            self._add(name, colour, self._find_or_add_texture(texture) if texture else None)
        return self._names[key]

    def add_sheet(self, pixels: Pixels) -> str:
        """Add a material with the colours of a sheet, and return its name.

        pixels: red, green and blue, (rows, columns, 3). The first row has the least texture coordinate.
        """
        self._add_texture(SHEET, pixels)
        self._add(SHEET, WHITE, SHEET)
        return SHEET

    def add_sky(self, colour: Colour) -> None:
        """Add a sky of one colour to the model."""
        import mujoco

        rgb = [part / 255 for part in colour]
        self._spec.add_texture(
            name="sky",
            type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
            rgb1=rgb,
            rgb2=rgb,
            width=8,
            height=48,
        )

    def _find_or_add_texture(self, texture: Texture) -> str:
        if texture not in self._textures:
            self._textures[texture] = name = f"texture_{len(self._textures)}"
            self._add_texture(name, np.repeat(texture.tile[:, :, None], 3, axis=2))
        return self._textures[texture]

    def _add(self, name: str, colour: Colour, texture: str | None) -> None:
        import mujoco

        material = self._spec.add_material(name=name, rgba=rgba(colour), specular=0.0, shininess=0.0, reflectance=0.0)
        if texture:
            material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = texture

    def _add_texture(self, name: str, pixels: Pixels) -> None:
        import mujoco

        height, width, channels = pixels.shape
        texture = self._spec.add_texture(
            name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=channels
        )
        texture.data = pixels.tobytes()
