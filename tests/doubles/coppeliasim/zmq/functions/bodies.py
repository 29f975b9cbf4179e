"""The functions about joints, shapes and poses. Joints are revolute."""

from __future__ import annotations

from typing import Any

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import Joint, Node, Shape
from tests.doubles.coppeliasim.scene.poses import ORIGIN, Transform, from_euler, normalise, to_euler
from tests.doubles.coppeliasim.zmq.functions.registry import floats, function
from tests.doubles.coppeliasim.zmq.session import Session

REVOLUTE = 10
KINEMATIC, DYNAMIC = 0, 5


@function("setJointTargetVelocity")
def set_joint_target_velocity(session: Session, joint: Joint, velocity: float) -> int:
    """Set the target velocity. NaN is accepted, as on the real server."""
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
    """`set_joint_target_force` under its name before CoppeliaSim 4.4."""
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
    """Set the interval. The joint does not stop at its ends, because wheels never reach them."""
    joint.is_cyclic = is_cyclic
    least, span = floats(interval, 2)
    joint.interval = (least, span)
    return 1


AMBIENT_DIFFUSE = 0


@function("setShapeColor")
def set_shape_color(session: Session, shape: Shape, name: Any, component: int, colour: list) -> int:  # type: ignore[type-arg]
    if component == AMBIENT_DIFFUSE:
        red, green, blue = floats(colour, 3)
        shape.colour = (red, green, blue)
        session.simulator.graph.revision += 1
    else:
        session.shared.stored_values[shape, "colour", component] = [float(part) for part in colour[:3]]
    return 1


@function("getShapeColor")
def get_shape_color(session: Session, shape: Shape, name: Any, component: int) -> tuple[int, list[float]]:
    if component == AMBIENT_DIFFUSE:
        return 1, list(shape.colour)
    if (shape, "colour", component) not in session.shared.stored_values:
        raise SceneError(f"the double has no value of colour component {component}, because it was not set.")
    return 1, session.shared.stored_values[shape, "colour", component]


@function("computeMassAndInertia")
def compute_mass_and_inertia(session: Session, shape: Shape, density: float) -> int:
    shape.mass = density * shape.volume
    return 1


@function("setShapeMass")
def set_shape_mass(session: Session, shape: Shape, mass: float) -> None:
    shape.mass = mass


@function("getShapeMass")
def get_shape_mass(session: Session, shape: Shape) -> float:
    return shape.mass


@function("setShapeInertia")
def set_shape_inertia(session: Session, shape: Shape, inertia: list, frame: list) -> None:  # type: ignore[type-arg]
    session.shared.stored_values[shape, "inertia"] = (
        [float(part) for part in inertia],
        [float(part) for part in frame],
    )


@function("getShapeBB")
def get_shape_bb(session: Session, shape: Shape) -> tuple[list[float], list[float]]:
    return list(shape.size), ORIGIN.pose


@function("getShapeGeomInfo")
def get_shape_geom_info(session: Session, shape: Shape) -> tuple[int, int, list[float]]:
    """Return bits (1: pure primitive, 2: convex), the primitive, and the lengths."""
    return 6, int(shape.primitive), [*shape.size, 0.0]


@function("resetDynamicObject")
def reset_dynamic_object(session: Session, shape: Shape) -> int:
    """Do nothing, because the double stores no dynamic state of a shape."""
    return 1


WORLD = -1
PARENT = -11


@function("getObjectPose")
def get_object_pose(session: Session, node: Node, relative_to: int = WORLD) -> list[float]:
    return _place(session, node, relative_to).pose


@function("setObjectPose")
def set_object_pose(session: Session, node: Node, pose: list, relative_to: int = WORLD) -> None:  # type: ignore[type-arg]
    _put(session, node, Transform.of_pose(floats(pose, 7)), relative_to)


@function("getObjectPosition")
def get_object_position(session: Session, node: Node, relative_to: int = WORLD) -> list[float]:
    return list(_place(session, node, relative_to).position)


@function("setObjectPosition")
def set_object_position(session: Session, node: Node, position: list, relative_to: int = WORLD) -> None:  # type: ignore[type-arg]
    x, y, z = floats(position, 3)
    _put(session, node, _place(session, node, relative_to)._replace(position=(x, y, z)), relative_to)


@function("getObjectOrientation")
def get_object_orientation(session: Session, node: Node, relative_to: int = WORLD) -> list[float]:
    return to_euler(_place(session, node, relative_to).quaternion)


@function("setObjectOrientation")
def set_object_orientation(session: Session, node: Node, angles: list, relative_to: int = WORLD) -> None:  # type: ignore[type-arg]
    quaternion = from_euler(floats(angles, 3))
    _put(session, node, _place(session, node, relative_to)._replace(quaternion=quaternion), relative_to)


@function("getObjectQuaternion")
def get_object_quaternion(session: Session, node: Node, relative_to: int = WORLD) -> list[float]:
    return list(_place(session, node, relative_to).quaternion)


@function("setObjectQuaternion")
def set_object_quaternion(session: Session, node: Node, quaternion: list, relative_to: int = WORLD) -> None:  # type: ignore[type-arg]
    x, y, z, w = floats(quaternion, 4)
    _put(session, node, _place(session, node, relative_to)._replace(quaternion=normalise((x, y, z, w))), relative_to)


@function("getObjectMatrix")
def get_object_matrix(session: Session, node: Node, relative_to: int = WORLD) -> list[float]:
    place = _place(session, node, relative_to)
    return [part for row in zip(*place.axes, place.position, strict=True) for part in row]


@function("getObjectVelocity")
def get_object_velocity(session: Session, node: Node) -> tuple[list[float], list[float]]:
    linear, angular = session.simulator.velocity(node)
    return list(linear), list(angular)


def _place(session: Session, node: Node, relative_to: int) -> Transform:
    if relative_to == PARENT:
        return node.local
    graph = session.simulator.graph
    pose = graph.pose(node)
    return pose if relative_to == WORLD else graph.pose(graph[relative_to]).inverse.compose(pose)


def _put(session: Session, node: Node, place: Transform, relative_to: int) -> None:
    graph = session.simulator.graph
    if relative_to == WORLD:
        graph.put(node, place)
    elif relative_to == PARENT:
        graph.put(node, graph.frame(node.parent).compose(place))
    else:
        graph.put(node, graph.pose(graph[relative_to]).compose(place))
