from __future__ import annotations

import re

import pytest

from robotcore.description import RobotDescription, load_robot
from robotcore.errors import UsageError
from robotcore.hal.robot import Role
from robotcore.runtime.faults import Kind, plan_faults
from robotcore.runtime.faults.planning import Target
from robotcore.runtime.layers import needed_devices
from tests.robotcore.fakes import ROVER

LOOKOUT = load_robot("lookout")
DRIVING = needed_devices(ROVER, {Role.DRIVE})
EVERYTHING = frozenset(device.name for device in ROVER.devices)


@pytest.mark.parametrize(
    "spec, kind, devices",
    [
        ("eye drop=0.1", Kind.CAMERA, {"eye"}),
        ("camera drop=0.1", Kind.CAMERA, {"eye"}),
        ("range drop=0.1", Kind.RANGE, {"nose"}),
        ("encoders drop=0.1", Kind.ENCODER, {"left_encoder", "right_encoder"}),
        ("drive dead", Kind.MOTOR, {"left_motor", "right_motor"}),
        ("loop stall=0.1", Kind.LOOP, set()),
        ("connection lost=1", Kind.CONNECTION, EVERYTHING),
    ],
)
def test_a_target_is_a_device_or_a_role_or_the_loop_or_the_connection(spec: str, kind: Kind, devices: set[str]) -> None:
    (planned,) = plan_faults([spec], ROVER, EVERYTHING)
    assert planned.target == Target(kind, frozenset(devices))


def test_a_role_is_the_first_device_of_its_kind_as_for_an_app() -> None:
    eye = next(device for device in LOOKOUT.devices if device.name == "eye")
    second = eye.model_copy(update={"name": "second"})
    robot = LOOKOUT.model_copy(update={"devices": (*LOOKOUT.devices, second)})
    (planned,) = plan_faults(["camera drop=0.1"], robot, {"eye", "second"})
    assert planned.target.devices == {"eye"}


def test_a_robot_without_encoders_has_none_to_fail() -> None:
    assert ROVER.drive
    drive = ROVER.drive.model_copy(update={"left_encoder": None, "right_encoder": None})
    robot = ROVER.model_copy(update={"drive": drive})
    _refused("encoders slip=0.1", "unknown target 'encoders'", robot, DRIVING - {"left_encoder", "right_encoder"})


@pytest.mark.parametrize(
    "spec, fault, form",
    [
        ("eyes drop=0.2", "unknown target 'eyes'. Did you mean 'eye'?", "robotcore faults lists"),
        (
            "screen drop=0.2",
            "drop is for camera or range or encoders or battery; on a display there are: lost",
            "camera drop=",
        ),
        (
            "connection lost=2 lasts=1",
            "lasts=1 is for how long it may begin again; say with every=SECONDS how often, or leave",
            "lost=",
        ),
        ("camera dorp=0.2", "unknown effect 'dorp'. Did you mean 'drop'?", "robotcore faults lists"),
        ("camera drop=0.2 aftr=5", "unknown parameter 'aftr'. Did you mean 'after'?", "camera drop=PROBABILITY"),
        ("camera drop=0.2 value=0.3", "unknown parameter 'value'", "camera drop=PROBABILITY"),
        ("camera drop=1.5", "drop should be at most 1, got '1.5'", "camera drop=PROBABILITY"),
        ("camera drop=much", "drop should be a number, got 'much'", "camera drop=PROBABILITY"),
        ("camera drop=nan", "drop should be a finite number, got 'nan'", "camera drop=PROBABILITY"),
        ("camera drop=0.2 after=-1", "after should be at least 0, got '-1'", "[after=SECONDS]"),
        ("camera drop", "drop needs a value", "camera drop=PROBABILITY [after=SECONDS] [lasts=SECONDS]"),
        ("nose noise=2", "noise should be at most 1", "nose noise=METRES"),
        ("camera noise=0", "noise should be greater than 0", "camera noise=GREY_LEVELS"),
        ("camera freeze=1", "freeze takes no value", "camera freeze [after=SECONDS] [lasts=SECONDS]"),
        (
            "left_motor drop=0.2",
            "drop is for camera or range or encoders or battery; on a motor there are: dead, ",
            "camera drop=",
        ),
        (
            "camera stall=1",
            "stall is for loop; on a camera there are: delay, drop, freeze, lost, noise",
            "loop stall=0.3",
        ),
        ("loop stall=2 every=1", "every=1 comes before the end of 2 seconds; take it longer", "[every=SECONDS]"),
        ("loop stall=1000", "stall should be at most 60", "loop stall=SECONDS"),
    ],
)
def test_what_does_not_fit_is_told_with_the_right_form_in_two_lines(spec: str, fault: str, form: str) -> None:
    told = _refused(spec, fault)
    first, second = told.splitlines()
    assert first.startswith(f"--fault '{spec}': ")
    assert form in second


def test_what_the_robot_has_and_the_app_does_not_open_is_told_so() -> None:
    told = _refused("camera drop=0.2", "the app opens no camera; what it opens that can fail: connection, drive,")
    assert "nose" in told


def _refused(
    spec: str, fault: str, robot: RobotDescription = ROVER, opened: frozenset[str] = DRIVING | {"eye", "screen"}
) -> str:
    opened = DRIVING if "opens no" in fault else opened
    with pytest.raises(UsageError, match=re.escape(fault)) as raised:
        plan_faults([spec], robot, opened)
    return str(raised.value)
