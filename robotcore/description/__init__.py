"""The descriptions of robots and worlds, which are loaded from TOML files.

The names in ``__all__`` are public. The other packages of robotcore import the names with ``as`` from here too.
"""

from robotcore.description.conditions import Conditions, Light, Randomisation
from robotcore.description.devices import DeviceDescription, Ideal, Mount, SensorDescription
from robotcore.description.drive import AckermannDrive, Caster, Drive, DriveWheel, SkidDrive, TwoWheelDrive
from robotcore.description.floor_image import FloorImage
from robotcore.description.generation.domain_randomisation import DrawnValues as DrawnValues
from robotcore.description.generation.domain_randomisation import RandomisedWorld as RandomisedWorld
from robotcore.description.generation.domain_randomisation import describe_conditions as describe_conditions
from robotcore.description.generation.domain_randomisation import describe_light as describe_light
from robotcore.description.generation.domain_randomisation import describe_picture as describe_picture
from robotcore.description.generation.domain_randomisation import randomise as randomise
from robotcore.description.generation.gaps import require_room as require_room
from robotcore.description.generation.gaps import require_start as require_start
from robotcore.description.generation.random_layout import draw_world
from robotcore.description.generation.reachability import is_solvable as is_solvable
from robotcore.description.lines import Line
from robotcore.description.loading import find_floor_image as find_floor_image
from robotcore.description.loading import is_own as is_own
from robotcore.description.loading import load_any as load_any
from robotcore.description.loading import load_robot, load_world, robot_names, world_names
from robotcore.description.loading import read_shipped as read_shipped
from robotcore.description.loading import read_table as read_table
from robotcore.description.robot import Body, RobotDescription, Safety
from robotcore.description.texture import Texture
from robotcore.description.types import COLOURS, StrictModel
from robotcore.description.types import hue_degrees as hue_degrees
from robotcore.description.validation import first_mistake as first_mistake
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
    "Drive",
    "DriveWheel",
    "Floor",
    "FloorImage",
    "Ideal",
    "Light",
    "Line",
    "Mount",
    "Randomisation",
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
    "draw_world",
    "load_robot",
    "load_world",
    "robot_names",
    "world_names",
]
