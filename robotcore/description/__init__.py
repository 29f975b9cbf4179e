"""Robot and world descriptions: one file makes the simulators' models and the real robot's wiring."""

from robotcore.description.base import COLOURS, Described, hue_degrees
from robotcore.description.conditions import Conditions
from robotcore.description.drawing import draw_world
from robotcore.description.faults import first_fault
from robotcore.description.light import Light
from robotcore.description.loading import (
    is_own,
    load_any,
    load_robot,
    load_world,
    read_table,
    robot_names,
    world_names,
)
from robotcore.description.passage import is_solvable
from robotcore.description.placement import require_room, require_start
from robotcore.description.randomisation import Randomisation
from robotcore.description.randomising import Randomised, Told, randomise
from robotcore.description.robot import (
    AnyDevice,
    BatteryDescription,
    Body,
    CameraDescription,
    Caster,
    DisplayDescription,
    Drive,
    EncoderDescription,
    MotorDescription,
    Mount,
    RangeSensorDescription,
    RobotDescription,
    Safety,
    SimulatedDevice,
)
from robotcore.description.telling import conditions_told, light_told, picture_told
from robotcore.description.texture import Texture
from robotcore.description.world import (
    Ball,
    Box,
    Cylinder,
    Floor,
    Start,
    Variation,
    Walls,
    WorldDescription,
)

__all__ = [
    "COLOURS",
    "AnyDevice",
    "Ball",
    "BatteryDescription",
    "Body",
    "Box",
    "CameraDescription",
    "Caster",
    "Conditions",
    "Cylinder",
    "Described",
    "DisplayDescription",
    "Drive",
    "EncoderDescription",
    "Floor",
    "Light",
    "MotorDescription",
    "Mount",
    "Randomisation",
    "Randomised",
    "RangeSensorDescription",
    "RobotDescription",
    "Safety",
    "SimulatedDevice",
    "Start",
    "Texture",
    "Told",
    "Variation",
    "Walls",
    "WorldDescription",
    "conditions_told",
    "draw_world",
    "first_fault",
    "hue_degrees",
    "is_own",
    "is_solvable",
    "light_told",
    "load_any",
    "load_robot",
    "load_world",
    "picture_told",
    "randomise",
    "read_table",
    "require_room",
    "require_start",
    "robot_names",
    "world_names",
]
