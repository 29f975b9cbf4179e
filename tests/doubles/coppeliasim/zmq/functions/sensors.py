"""The functions about vision sensors, proximity sensors and contacts."""

from __future__ import annotations

import numpy as np

from tests.doubles.coppeliasim.scene import SceneError
from tests.doubles.coppeliasim.scene.objects import Depths, Node, Pixels, ProximitySensor, VisionSensor
from tests.doubles.coppeliasim.scene.rays import Detection
from tests.doubles.coppeliasim.scene.states import State
from tests.doubles.coppeliasim.zmq.functions.registry import function
from tests.doubles.coppeliasim.zmq.session import Session

GREY, METRES = 1, 1


@function("getVisionSensorImg")
def get_vision_sensor_img(
    session: Session,
    sensor: VisionSensor,
    options: int = 0,
    cut_off: float = 0.0,
    corner: list | None = None,  # type: ignore[type-arg]
    size: list | None = None,  # type: ignore[type-arg]
) -> tuple[bytes, list[int]]:
    """Return the pixels, RGB or grey (bit 0 of the options), the lowest row first, and the size of the sensor."""
    if cut_off:
        raise SceneError("the double does not support the argument cut_off of pictures.")
    picture = _crop(session.simulator.picture(sensor), corner, size)
    return (_grey(picture) if options & GREY else picture).tobytes(), [sensor.width, sensor.height]


@function("getVisionSensorCharImage")
def get_vision_sensor_char_image(session: Session, sensor: VisionSensor) -> tuple[bytes, int, int]:
    """`get_vision_sensor_img` under its name before CoppeliaSim 4.4."""
    return session.simulator.picture(sensor).tobytes(), sensor.width, sensor.height


@function("setVisionSensorImg")
def set_vision_sensor_img(session: Session, sensor: VisionSensor, pixels: bytes, options: int = 0) -> int:
    channels = 1 if options & GREY else 3
    size = sensor.width * sensor.height * channels
    if not isinstance(pixels, bytes) or len(pixels) < size:
        raise SceneError("incorrect buffer size.")
    shape = (sensor.height, sensor.width, channels)
    picture = np.frombuffer(pixels, np.uint8, size).reshape(shape)
    session.simulator.show(sensor, np.ascontiguousarray(np.broadcast_to(picture, (*shape[:2], 3))))
    return 1


@function("getVisionSensorRes")
def get_vision_sensor_res(session: Session, sensor: VisionSensor) -> list[int]:
    return [sensor.width, sensor.height]


@function("getVisionSensorResolution")
def get_vision_sensor_resolution(session: Session, sensor: VisionSensor) -> list[int]:
    """`get_vision_sensor_res` under its name before CoppeliaSim 4.4."""
    return [sensor.width, sensor.height]


@function("getVisionSensorDepth")
def get_vision_sensor_depth(session: Session, sensor: VisionSensor, options: int = 0) -> tuple[bytes, list[int]]:
    """Return depths, in metres if bit 0 of the options is set.

    Otherwise a depth is 0 at the near plane and 1 at the far plane.
    """
    depths = session.simulator.depth(sensor)
    values = depths if options & METRES else _normalised(sensor, depths)
    return values.astype("<f4").tobytes(), [sensor.width, sensor.height]


@function("getVisionSensorDepthBuffer")
def get_vision_sensor_depth_buffer(session: Session, sensor: VisionSensor) -> list[float]:
    """`get_vision_sensor_depth` under its name before CoppeliaSim 4.4, with other option bits."""
    return [float(depth) for depth in _normalised(sensor, session.simulator.depth(sensor)).ravel()]


@function("handleVisionSensor")
def handle_vision_sensor(session: Session, sensor: VisionSensor) -> tuple[int, list[float], list[float]]:
    session.simulator.handle(sensor)
    return _compute_result(session, sensor)


@function("readVisionSensor")
def read_vision_sensor(session: Session, sensor: VisionSensor) -> int | tuple[int, list[float], list[float]]:
    return _compute_result(session, sensor) if sensor.has_result else -1


@function("getExplicitHandling")
def get_explicit_handling(session: Session, node: Node) -> int:
    return int(node.explicit)


@function("setExplicitHandling")
def set_explicit_handling(session: Session, node: Node, is_explicit: int) -> int:
    node.explicit = bool(is_explicit & 1)
    return 1


def _compute_result(session: Session, sensor: VisionSensor) -> tuple[int, list[float], list[float]]:
    """Return the state and 15 numbers: the minima, maxima and means of intensity, red, green, blue and depth."""
    picture, seen = session.simulator.summary(sensor)
    depths = _normalised(sensor, seen).ravel()
    layers = np.concatenate((_grey(picture).reshape(-1, 1), picture.reshape(-1, 3)), axis=1)
    numbers: list[float] = []
    for reduced in (np.min, np.max, np.mean):
        numbers += [int(value) / 255 for value in reduced(layers, axis=0)]
        numbers.append(float(np.float32(reduced(depths))))
    return 0, numbers, []


def _normalised(sensor: VisionSensor, depths: Depths) -> Depths:
    parts = (depths - sensor.near) / (sensor.far - sensor.near)
    return np.asarray(parts, np.float32)


def _grey(picture: Pixels) -> Pixels:
    return np.asarray(picture.mean(axis=2, dtype=np.float32), np.uint8)


def _crop(picture: Pixels, corner: list[int] | None, size: list[int] | None) -> Pixels:
    """Return a part of a picture. A size of 0 stands for the whole picture."""
    if not size or not any(size):
        return picture
    (x, y), (width, height) = corner or (0, 0), size
    return picture[y : y + height, x : x + width]


HANDLE_ALL = -2

Answer = tuple[int, float, list[float], int, list[float]]


@function("readProximitySensor")
def read_proximity_sensor(session: Session, sensor: ProximitySensor) -> Answer:
    """Return the detection in the last step. While the simulation is stopped, nothing is detected."""
    if session.simulator.state is State.STOPPED and not sensor.explicit:
        return _answer(None)
    return _answer(session.simulator.detection(sensor))


@function("handleProximitySensor")
def handle_proximity_sensor(session: Session, sensor: ProximitySensor) -> Answer:
    _require_explicit(sensor)
    return _answer(session.simulator.detection(sensor))


@function("checkProximitySensor")
def check_proximity_sensor(session: Session, sensor: ProximitySensor, entity: int) -> Answer:
    if entity != HANDLE_ALL:
        raise SceneError("the double checks proximity sensors against all objects only.")
    return _answer(session.simulator.detection(sensor))


@function("resetProximitySensor")
def reset_proximity_sensor(session: Session, sensor: ProximitySensor) -> int:
    """Do nothing, because the double stores no state of a sensor."""
    _require_explicit(sensor)
    return 1


def _require_explicit(sensor: ProximitySensor) -> None:
    if not sensor.explicit:
        raise SceneError("object not tagged for explicit handling.")


def _answer(detection: Detection | None) -> Answer:
    if detection is None:
        return 0, 0.0, [0.0, 0.0, 0.0], -1, [0.0, 0.0, 0.0]
    return 1, detection.distance, list(detection.point), detection.handle, list(detection.normal)


@function("getContactInfo")
def get_contact_info(
    session: Session, passes: int, shape: int, index: int
) -> tuple[list[int], list[float], list[float], list[float]]:
    """Return the two shapes of a contact, its point, force and normal. The result is empty after the last contact."""
    contacts = session.simulator.contacts()
    if shape != HANDLE_ALL:
        both = [each if each.first == shape else each.swap for each in contacts]
        contacts = [each for each in both if each.first == shape]
    if index >= len(contacts):
        return [], [], [], []
    found = contacts[index]
    return [found.first, found.second], list(found.point), list(found.force), list(found.normal)


@function("checkCollision")
def check_collision(session: Session, one: int, other: int) -> tuple[int, list[int]]:
    _require_no_plugin(session)
    return 0, [-1, -1]


@function("checkDistance")
def check_distance(
    session: Session, one: int, other: int, threshold: float = 0.0
) -> tuple[int, list[float], list[int]]:
    _require_no_plugin(session)
    return 0, [0.0] * 7, [-1, -1]


def _require_no_plugin(session: Session) -> None:
    """Refuse a call that the real server can answer only with the plug-in."""
    if session.simulator.can_detect:
        raise SceneError("the double computes neither collisions nor distances; call getContactInfo.")
