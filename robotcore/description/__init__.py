"""The descriptions of robots and worlds, which are loaded from TOML files."""

from robotcore.description.conditions import Conditions, Light, Randomisation
from robotcore.description.devices import DeviceDescription, Ideal, Mount, SensorDescription
from robotcore.description.drive import AckermannDrive, Caster, Drive, DriveWheel, SkidDrive, TwoWheelDrive
from robotcore.description.floor_image import FloorImage
from robotcore.description.generation.domain_randomisation import (
    DrawnValues,
    RandomisedWorld,
    describe_conditions,
    describe_light,
    describe_picture,
    randomise,
)
from robotcore.description.generation.gaps import require_room, require_start
from robotcore.description.generation.random_layout import draw_world
from robotcore.description.generation.reachability import is_solvable
from robotcore.description.lines import Line
from robotcore.description.loading import (
    find_floor_image,
    is_own,
    load_any,
    load_robot,
    load_world,
    read_table,
    robot_names,
    world_names,
)
from robotcore.description.robot import Body, RobotDescription, Safety
from robotcore.description.texture import Texture
from robotcore.description.types import COLOURS, StrictModel, hue_degrees
from robotcore.description.validation import first_mistake
from robotcore.description.world import Ball, Box, Cylinder, Floor, Start, Variation, Walls, WorldDescription

__all__ = [
    "COLOURS",
    "AckermannDrive",
    "Ball",
    "Body",
    "Box",
    "Caster",
    "Conditions",
    "Cylinder",
    "DeviceDescription",
    "DrawnValues",
    "Drive",
    "DriveWheel",
    "Floor",
    "FloorImage",
    "Ideal",
    "Light",
    "Line",
    "Mount",
    "Randomisation",
    "RandomisedWorld",
    "RobotDescription",
    "Safety",
    "SensorDescription",
    "SkidDrive",
    "Start",
    "StrictModel",
    "Texture",
    "TwoWheelDrive",
    "Variation",
    "Walls",
    "WorldDescription",
    "describe_conditions",
    "describe_light",
    "describe_picture",
    "draw_world",
    "find_floor_image",
    "first_mistake",
    "hue_degrees",
    "is_own",
    "is_solvable",
    "load_any",
    "load_robot",
    "load_world",
    "randomise",
    "read_table",
    "require_room",
    "require_start",
    "robot_names",
    "world_names",
]
