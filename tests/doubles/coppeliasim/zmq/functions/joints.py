"""Joints: revolute ones, moved by their target velocity."""

from __future__ import annotations

from tests.doubles.coppeliasim.scene.objects import Joint
from tests.doubles.coppeliasim.zmq.functions.registry import floats, function
from tests.doubles.coppeliasim.zmq.session import Session

REVOLUTE = 10
KINEMATIC, DYNAMIC = 0, 5


@function("setJointTargetVelocity")
def set_joint_target_velocity(session: Session, joint: Joint, velocity: float) -> int:
    """NaN is taken without a word, as the real server does."""
    joint.target_velocity = velocity
    return 1


@function("getJointTargetVelocity")
def get_joint_target_velocity(session: Session, joint: Joint) -> float:
    return joint.target_velocity


@function("getJointVelocity")
def get_joint_velocity(session: Session, joint: Joint) -> float:
    return joint.velocity


@function("getJointPosition")
def get_joint_position(session: Session, joint: Joint) -> float:
    return joint.position


@function("setJointPosition")
def set_joint_position(session: Session, joint: Joint, position: float) -> int:
    joint.turn_to(position)
    session.simulator.graph.revision += 1
    return 1


@function("setJointTargetForce")
def set_joint_target_force(session: Session, joint: Joint, force: float) -> None:
    joint.target_force = force


@function("setJointMaxForce")
def set_joint_max_force(session: Session, joint: Joint, force: float) -> int:
    """The name until 4.3."""
    joint.target_force = force
    return 1


@function("getJointTargetForce")
def get_joint_target_force(session: Session, joint: Joint) -> float:
    return joint.target_force


@function("getJointType")
def get_joint_type(session: Session, joint: Joint) -> int:
    return REVOLUTE


@function("getJointMode")
def get_joint_mode(session: Session, joint: Joint) -> tuple[int, int]:
    return (DYNAMIC if joint.is_dynamic else KINEMATIC), 0


@function("setJointMode")
def set_joint_mode(session: Session, joint: Joint, mode: int, options: int = 0) -> int:
    joint.is_dynamic = mode == DYNAMIC
    session.simulator.graph.revision += 1
    return 1


@function("getJointInterval")
def get_joint_interval(session: Session, joint: Joint) -> tuple[bool, list[float]]:
    return joint.is_cyclic, list(joint.interval)


@function("setJointInterval")
def set_joint_interval(session: Session, joint: Joint, is_cyclic: bool, interval: list) -> int:  # type: ignore[type-arg]
    """It is not stopped at the interval's ends: wheels are not driven so far."""
    joint.is_cyclic = is_cyclic
    least, span = floats(interval, 2)
    joint.interval = (least, span)
    return 1
