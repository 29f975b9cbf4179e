"""LD06 and RPLIDAR A1 on real ptys, with doubles that send the bytes of their manuals."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, suppress
from dataclasses import replace
from itertools import chain, repeat
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from serial import Serial

from drivers.kinematic.backend import KinematicBackend
from drivers.serial.ranging.ld06 import LD06
from drivers.serial.ranging.ld06 import Parser as LD06Parser
from drivers.serial.ranging.lidar import MAX_GAP_RAD, LidarDriver, ScanBuilder
from drivers.serial.ranging.rplidar import HEALTH_ANSWER, SCAN_ANSWER, Node, NodeParser, RPLidarA1, RPLidarProtocol
from robotcore.description import Mount, RobotDescription, load_robot
from robotcore.errors import DescriptionError, DeviceError, DeviceLostError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.robot import Robot
from robotcore.hardware import DeviceContext, bind_devices, open_robot
from robotcore.kinds.lidar import Lidar, LidarDescription
from robotcore.testing import TestSupport
from robotcore.testing.kind_rules import KindRules
from robotcore.testing.lifecycle_rules import LifecycleRules
from robotcore.testing.time_rules import SampleRules
from tests.doubles.serial.board import Powered
from tests.doubles.serial.lidars import LD06Double, RPLidarDouble, build_node, build_packet
from tests.doubles.serial.pty import Pty
from tests.texts import Raises

SCANNER = LidarDescription(
    kind="lidar", name="scanner", mount=Mount(z_m=0.12), min_range_m=0.15, max_range_m=8.0, count=360
)
Double = LD06Double | RPLidarDouble
DRIVERS: Mapping[type[LidarDriver], type[Double]] = {LD06: LD06Double, RPLidarA1: RPLidarDouble}
every_lidar = pytest.mark.parametrize("rig", DRIVERS, indirect=True, ids=lambda driver: driver.name)
ld06 = pytest.mark.parametrize("rig", [LD06], indirect=True, ids=["ld06"])
rplidar = pytest.mark.parametrize("rig", [RPLidarA1], indirect=True, ids=["rplidar-a1"])


def corner(bearing: float) -> float:
    """Return the distance to a wall 2 m ahead and another one 1 m to the left."""
    ahead = 2.0 / math.cos(bearing) if math.cos(bearing) > 0.1 else math.inf
    left = 1.0 / math.sin(bearing) if math.sin(bearing) > 0.1 else math.inf
    return near if (near := min(ahead, left)) < 7.0 else math.inf


class Rig:
    """A lidar's double on a pty, in simulated time."""

    def __init__(self, folder: Path, driver: type[LidarDriver]) -> None:
        self.driver, self.pty, self.clock = driver, Pty(folder), SteppedClock(500, lambda _steps: None)
        self.double: Any = DRIVERS[driver](corner)
        self._opened = ExitStack()
        self._opened.enter_context(self.pty)
        self._opened.callback(Powered(self.double, self.pty, self.clock).off)

    def open(self, description: LidarDescription = SCANNER, **settings: Any) -> Lidar:
        driver = self.driver(port=str(self.pty.path), **settings)
        lidar = driver.open(description, DeviceContext(load_robot("rover"), self.clock))
        assert isinstance(lidar, Lidar)
        self._opened.callback(lidar.close)
        return lidar

    def wait(self, seconds: float) -> None:
        self.clock.sleep_until(self.clock.now() + seconds)

    def close(self) -> None:
        self._opened.close()


@pytest.fixture
def rig(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Rig]:
    rig = Rig(tmp_path, request.param)
    yield rig
    rig.close()


@every_lidar
def test_scan_has_the_distances_of_the_bearings(rig: Rig) -> None:
    lidar = rig.open()
    scan = lidar.read()
    assert [scan.distances[index] for index in (180, 270, 0)] == pytest.approx([2.0, 1.0, math.inf], abs=0.002)
    for bearing, distance in zip(lidar.bearings, scan.distances, strict=True):
        near = [corner(bearing + offset * math.radians(1.2)) for offset in (-1, 0, 1)]
        assert min(near) - 0.01 <= distance <= max(near) + 0.01, math.degrees(bearing)


@every_lidar
def test_scan_has_the_time_of_its_first_measurement(rig: Rig) -> None:
    lidar = rig.open()
    before = lidar.read()
    rig.wait(1.0)
    after = lidar.read()
    turn_s = 0.1 if rig.driver is LD06 else 1 / 5.5
    assert after.sequence - before.sequence == pytest.approx(1 / turn_s, abs=1)
    assert turn_s - 0.01 <= rig.clock.now() - after.time <= 2 * turn_s + 0.01


@every_lidar
def test_narrow_field_of_view_has_its_rays_alone(rig: Rig) -> None:
    lidar = rig.open(SCANNER.model_copy(update={"start_rad": 0.0, "end_rad": math.pi / 2, "count": 91}))
    distances = lidar.read().distances
    assert len(distances) == 91
    assert [distances[0], distances[-1]] == pytest.approx([2.0, 1.0], abs=0.02)


@every_lidar
def test_distance_outside_the_range_is_no_echo(rig: Rig) -> None:
    rig.double.measure = lambda bearing: 0.1 if bearing % math.tau < math.pi else 9.0
    assert set(rig.open().read().distances) == {math.inf}


@every_lidar
def test_open_field_is_a_scan_without_echoes(rig: Rig) -> None:
    rig.double.measure = lambda _bearing: math.inf
    assert set(rig.open().read().distances) == {math.inf}


@every_lidar
def test_stream_that_begins_inside_a_packet_is_read(rig: Rig) -> None:
    starts = chain([3], repeat(0))
    rig.double.change = lambda data: data[next(starts) :]
    assert rig.open().read().distances[180] == pytest.approx(2.0, abs=0.002)


@every_lidar
@pytest.mark.slow
@pytest.mark.parametrize("damage", ["lost byte", "noise"])
def test_damaged_turn_makes_no_scan_and_the_next_one_does(rig: Rig, damage: str) -> None:
    lidar = rig.open()
    damaged = random.Random(5)

    def change(data: bytes) -> bytes:
        at = damaged.randrange(len(data))
        return data[:at] + data[at + 1 :] if damage == "lost byte" else damaged.randbytes(len(data))

    rig.double.change = change
    rig.wait(0.3)
    seen = set[float]()
    rig.double.change = bytes
    for _ in range(100):
        rig.wait(0.01)
        with suppress(DeviceLostError):
            seen.update(lidar.read().distances)
    assert lidar.read().distances[180] == pytest.approx(2.0, abs=0.002)
    true = [corner(angle) for angle in np.linspace(-math.pi, math.pi, 36_000)]
    assert all(min(abs(each - one) for one in true) < 0.01 for each in seen if math.isfinite(each))


@every_lidar
def test_silent_lidar_is_lost_until_its_next_scan(rig: Rig, raises: Raises) -> None:
    lidar = rig.open()
    before = lidar.read()
    rig.double.change = lambda _data: b""
    rig.wait(1.0)
    with raises(DeviceLostError, "board-silent", device="scanner"):
        lidar.read()
    rig.double.change = bytes
    rig.wait(3.0)
    assert lidar.read().time > before.time + 1.0


@every_lidar
def test_unplugged_lidar_is_lost_and_works_after_replugging(rig: Rig, raises: Raises) -> None:
    lidar = rig.open()
    before = lidar.read()
    rig.pty.unplug()
    rig.wait(0.1)
    with raises(DeviceLostError, "port-lost", device="scanner"):
        lidar.read()
    rig.pty.plug_in()
    rig.wait(4.0)
    assert lidar.read().time > before.time


@every_lidar
@pytest.mark.parametrize("data", [b"", b'{"T":1001,"L":0,"R":0}\r\n'], ids=["nothing", "other-board"])
def test_other_device_on_the_port_is_reported(rig: Rig, data: bytes, raises: Raises) -> None:
    rig.double.live = lambda _now, _seconds: data
    rig.double.receive = lambda _data, _now: b""
    with raises(DeviceError, "board-silent", device="scanner", hide=["bytes"]):
        rig.open()


@ld06
def test_incomplete_packets_are_reported_as_received(rig: Rig, raises: Raises) -> None:
    rig.double.live = lambda _now, _seconds: b"\x54\x2c"
    with raises(DeviceError, "board-silent", device="scanner"):
        rig.open()


@ld06
def test_half_of_each_turn_is_no_scan(rig: Rig, raises: Raises) -> None:
    rig.double.change = lambda packet: packet if packet[5] < 0x46 else b""
    with raises(DeviceError, "no-sample-yet", device="scanner"):
        rig.open()


@ld06
def test_ld06_gets_no_data(rig: Rig) -> None:
    rig.open().close()
    assert rig.pty.read() == b""


@rplidar
def test_protected_lidar_is_reported_with_its_error(rig: Rig, raises: Raises) -> None:
    rig.double.health = b"\x02\x34\x12"
    with raises(DeviceError, "board-silent", device="scanner"):
        rig.open()


@rplidar
def test_lidar_that_does_not_turn_is_reported(rig: Rig, raises: Raises) -> None:
    rig.double.motor_turns = False
    with raises(DeviceError, "board-silent", device="scanner"):
        rig.open()


@rplidar
def test_lidar_that_a_killed_program_left_scanning_is_opened(rig: Rig) -> None:
    rig.wait(0.1)
    rig.double.receive(b"\xa5\x20", rig.clock.now())
    rig.wait(1.5)
    assert rig.double.is_scanning
    assert rig.open().read().distances[180] == pytest.approx(2.0, abs=0.002)


@rplidar
def test_closing_stops_the_scan(rig: Rig) -> None:
    lidar = rig.open()
    assert rig.double.is_scanning
    lidar.close()
    rig.wait(0.1)
    assert (rig.double.is_scanning, rig.double.requests[-1]) == (False, b"\xa5\x25")


@rplidar
def test_motor_turns_with_a_low_dtr_while_the_port_is_open(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pty has no DTR, so the test records what pyserial is asked to set."""
    levels: list[bool] = []
    monkeypatch.setattr(Serial, "_update_dtr_state", lambda self: levels.append(self._dtr_state))
    lidar = rig.open()
    assert levels == [False]
    lidar.close()
    assert levels == [False, True]


RECORDED = [
    # LD06 Development Manual, "Packet format"
    (
        "542c6808ab7ee000e4dc00e2d900e5d500e3d300e4d000e9cd00e4ca00e2c700e9c500e5c200e5c000e5be823a1a50",
        (2152, 32427, 33470, 6714),
        (224, 220, 217, 213, 211, 208, 205, 202, 199, 197, 194, 192),
    ),
]


@pytest.mark.parametrize("sent, head, distances", RECORDED)
def test_packet_of_the_manual_is_parsed(sent: str, head: tuple[int, ...], distances: tuple[int, ...]) -> None:
    packet, _ = LD06Parser().feed(2 * bytes.fromhex(sent))
    assert (packet.speed, packet.start, packet.end, packet.time_ms) == head
    assert packet.distances == distances
    assert packet.angles[[0, -1]].tolist() == [324.27, 334.7]


def test_packet_across_the_angle_0_has_rising_angles() -> None:
    packet, _ = LD06Parser().feed(2 * build_packet(355.0, 1.0, [1.0] * 12, 0.0))
    assert packet.angles.tolist() == pytest.approx([355, 356, 357, 358, 359, 0, 1, 2, 3, 4, 5, 6])


def test_packet_with_a_wrong_checksum_is_dropped() -> None:
    packet = build_packet(10.0, 0.8, [1.0] * 12, 0.0)
    parser = LD06Parser()
    assert parser.feed(2 * (packet[:-1] + bytes([packet[-1] ^ 1]))) == []


def test_nodes_are_parsed_by_the_protocol() -> None:
    nodes = [build_node(angle, distance, is_first=angle == 0) for angle, distance in [(0.0, 1.5), (90.5, math.inf)]]
    parsed = NodeParser().feed(b"".join(nodes * 8))
    assert parsed[:2] == [Node(False, 90.5, math.inf), Node(True, 0.0, 1.5)]


def test_lost_byte_of_a_node_loses_few_nodes_and_makes_no_others() -> None:
    true = [Node(angle == 0, float(angle), (4000 + 16 * angle) / 4000) for angle in range(360)]
    stream = b"".join(build_node(node.angle, node.distance, is_first=node.is_first) for node in true)
    for at in range(500, 520):
        parser = NodeParser()
        parsed = parser.feed(stream[:at] + stream[at + 1 :])
        assert parser.losses == 1
        assert set(parsed) <= set(true)
        assert len(parsed) > 330


@pytest.mark.parametrize("first, last", [(0.0, 359.0), (359.9, 359.0), (0.5, 0.2)])
def test_nodes_without_an_echo_lie_between_their_neighbours(first: float, last: float) -> None:
    """The angles of such nodes are not reliable, so here all of them are 200°."""
    protocol = RPLidarProtocol(sampler := ScanBuilder(SCANNER), 115200)
    for data in (HEALTH_ANSWER + b"\0\0\0", SCAN_ANSWER):
        protocol.data_to_send(1.0)
        protocol.data_to_send(2.0)
        protocol.receive(data, 2.0)
    turn = [(first, 1.0), *[(200.0, math.inf)] * 178, (180.0, 2.0), *[(200.0, math.inf)] * 179, (last, 1.0)]
    nodes = [build_node(angle, distance, is_first=index == 0) for index, (angle, distance) in enumerate(turn)]
    for _ in range(3):
        protocol.receive(b"".join(nodes), 3.0)
    distances = sampler.newest.get().distances
    assert [index for index, distance in enumerate(distances) if math.isfinite(distance)] == pytest.approx(
        [0, 180, 181], abs=1
    )


@pytest.mark.parametrize("gap, scans", [(0.9, 1), (1.1, 0)])
def test_turn_with_a_gap_is_no_scan(gap: float, scans: int) -> None:
    sampler = ScanBuilder(SCANNER)
    angles = np.arange(0.0, 360.0 - gap * math.degrees(MAX_GAP_RAD), 0.1)
    sampler.add_revolution(angles, np.ones_like(angles), 0.0)
    assert sampler.has_scan is bool(scans)


def test_ray_has_the_shortest_distance_of_its_sector() -> None:
    sampler = ScanBuilder(SCANNER.model_copy(update={"count": 36}))
    angles = np.arange(0.0, 360.0)
    sampler.add_revolution(angles, np.where(angles == 353.0, 0.5, 2.0), 0.0)
    distances = sampler.newest.get().distances
    assert [index for index, distance in enumerate(distances) if distance == 0.5] == [19]


@pytest.mark.parametrize("driver", DRIVERS)
def test_longer_range_than_the_lidars_is_refused(driver: type[LidarDriver], raises: Raises) -> None:
    robot = robot_with(SCANNER.model_copy(update={"max_range_m": 13.0}), driver=driver.name, port="/dev/ttyUSB0")
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(robot, "serial", {"scanner"})


def robot_with(lidar: LidarDescription, **table: Any) -> RobotDescription:
    """Return the rover with a lidar, and with its table in [serial]."""
    rover = load_robot("rover")
    return rover.model_copy(update={"devices": (*rover.devices, lidar), "backends": {"serial": {lidar.name: table}}})


class _LidarSuite(LifecycleRules, KindRules, SampleRules):
    backend = KinematicBackend
    lacks: ClassVar = {TestSupport.SLOW_HARDWARE: "reading never asks the line: it talks by itself"}
    driver: ClassVar[type[LidarDriver]]

    @pytest.fixture(autouse=True)
    def _folder(self, tmp_path: Path) -> None:
        self._path = tmp_path

    @property
    def description(self) -> RobotDescription:
        return robot_with(SCANNER, driver=self.driver.name, port=str(self._path / "board"))

    def open(self, setup: Setup) -> Robot:
        with ExitStack() as undo:
            simulated = undo.enter_context(KinematicBackend().open(replace(setup, robot=setup.robot)))
            pty = undo.enter_context(Pty(self._path))
            double = DRIVERS[self.driver](_measure(simulated))
            undo.callback(Powered(double, pty, simulated.clock).off)
            release = undo.pop_all().close
        others = {name: device for name, device in simulated.devices.items() if not isinstance(device, Lidar)}
        bindings = bind_devices(setup.robot, "serial", setup.devices - others.keys())
        return open_robot(setup, bindings, simulated.clock, release=release, truth=simulated.truth, opened=others)


def _measure(simulated: Robot) -> Callable[[float], float]:
    """Return a function for the distance at a bearing; `inf` if the simulator has no lidar open."""
    lidars = [device for device in simulated.devices.values() if isinstance(device, Lidar)]

    def measure(bearing: float) -> float:
        return lidars[0].read().distances[round(math.degrees(bearing) + 180) % 360] if lidars else math.inf

    return measure


@pytest.mark.conformance
class TestLD06(_LidarSuite):
    driver = LD06


@pytest.mark.conformance
class TestRPLidarA1(_LidarSuite):
    driver = RPLidarA1
