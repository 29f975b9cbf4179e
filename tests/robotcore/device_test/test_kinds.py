"""The tests of each kind of device, on a virtual Pi whose wires differ from the robot's file, and by a person."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import tomlkit

from robotcore.description import load_robot
from robotcore.device_test.corrections import Corrections
from robotcore.device_test.live_device_test import LiveDeviceTest
from robotcore.hal.backend import load_backend
from robotcore.hal.device_test import Question
from robotcore.interactive.live_app import LiveApp
from robotcore.interactive.opening import open_request
from robotcore.runtime.request import RunRequest
from tests.robotcore.device_test.miswiring import BACKEND, SECTION, Table, build_true_robot


class ScriptedPerson:
    """A person with prepared answers, by ``DEVICE.TOPIC``. Other questions get no answer."""

    def __init__(self, answers: Mapping[str, Any] | None = None) -> None:
        self._answers = answers or {}
        self.asked: list[str] = []

    def answer(self, device: str, question: Question) -> str | float | None:
        self.asked.append(f"{device}.{question.topic}")
        found: str | float | None = self._answers.get(f"{device}.{question.topic}")
        return found

    def follow(self, device: str, topic: str, instruction: str) -> bool:
        self.asked.append(f"{device}.{topic}")
        return bool(self._answers.get(f"{device}.{topic}"))


Change = Callable[[Table], object]


def write(folder: Path, name: str, change: Change = lambda _tables: None) -> str:
    robot = build_true_robot()
    change(robot)
    (folder / name).write_text(tomlkit.dumps(robot))
    return str(folder / name)


@contextmanager
def open_test(
    folder: Path,
    *names: str,
    wrong: Change = lambda _robot: None,
    truth: Change = lambda _robot: None,
    person: ScriptedPerson | None = None,
    has_truth: bool = True,
) -> Iterator[LiveDeviceTest]:
    """Open some devices of a robot.

    wrong, truth: change the robot's file and that of the true robot.
    has_truth: whether the test may look at the true state of the simulator.
    """
    own, true = write(folder, "own.toml", wrong), write(folder, "true.toml", truth)
    request = RunRequest(
        LiveApp(frozenset(), frozenset(names)),
        BACKEND,
        own,
        "bench",
        timeout_s=1e9,
        options={"truth": true},
        has_separate_motors=True,
    )
    description = load_robot(own)
    corrections = Corrections(description, load_backend(BACKEND))
    with open_request(request) as live:
        test = LiveDeviceTest(live, description, corrections, person or ScriptedPerson())
        if not has_truth:
            test.state = None
        test.test_all(names)
        yield test


def kinds(test: LiveDeviceTest) -> dict[str, list[str]]:
    """Return the kinds of the findings by device."""
    found: dict[str, list[str]] = {}
    for finding in test.findings:
        found.setdefault(finding.subject, []).append(finding.kind)
    return found


def set_values(device: str, **values: Any) -> Change:
    return lambda robot: robot[SECTION][device].update(values)


def remove(device: str) -> Change:
    return lambda robot: robot[SECTION].pop(device)


WHEELS = ("left_motor", "right_motor", "left_encoder", "right_encoder")


def test_a_right_robot_works(tmp_path: Path) -> None:
    with open_test(tmp_path, *WHEELS) as test:
        assert kinds(test) == {name: ["works"] for name in WHEELS}
        assert not test.has_uncorrected_errors


def test_each_motor_stands_after_its_pulse(tmp_path: Path) -> None:
    with open_test(tmp_path, *WHEELS) as test:
        assert test.state
        before = dict(test.state.measure_wheel_angles())
        test.wait(1.0)
        assert test.state.measure_wheel_angles() == pytest.approx(before, abs=1e-3)


def test_a_motor_without_wires_is_dead(tmp_path: Path) -> None:
    with open_test(tmp_path, *WHEELS, truth=remove("right_motor")) as test:
        assert kinds(test) == {
            "left_motor": ["works"],
            "right_motor": ["motor-dead"],
            "left_encoder": ["works"],
            "right_encoder": ["not-tested"],
        }
        assert test.has_uncorrected_errors


def test_an_encoder_without_wires_is_dead(tmp_path: Path) -> None:
    with open_test(tmp_path, *WHEELS, truth=remove("left_encoder")) as test:
        assert kinds(test)["left_encoder"] == ["encoder-dead"]


def test_a_person_names_the_wheels(tmp_path: Path) -> None:
    person = ScriptedPerson({"left_motor.wheel": "rb", "right_motor.wheel": "lf"})
    with open_test(tmp_path, *WHEELS, person=person, has_truth=False) as test:
        found = kinds(test)
        assert found["left_motor"] == ["motors-swapped"]
        assert found["right_motor"] == ["motor-reversed"]


def test_without_a_person_the_encoders_show_that_a_motor_turns(tmp_path: Path) -> None:
    with open_test(tmp_path, *WHEELS, has_truth=False) as test:
        assert kinds(test)["left_motor"] == ["works"]
        assert "no person has confirmed" in test.findings[0].message


def test_without_a_person_a_contradiction_of_the_encoders_is_a_warning(tmp_path: Path) -> None:
    def swap(robot: Table) -> None:
        tables = robot[SECTION]
        tables["left_motor"], tables["right_motor"] = tables["right_motor"], tables["left_motor"]

    with open_test(tmp_path, *WHEELS, wrong=swap, has_truth=False) as test:
        assert kinds(test)["left_motor"] == ["motor-unconfirmed"]
        assert not test.has_uncorrected_errors


@pytest.mark.parametrize(
    "device,change,kind",
    [
        ("go", remove("go"), "contact-dead"),
        ("horn", remove("horn"), "buzzer-dead"),
        ("spot", remove("spot"), "light-dead"),
        ("pan", remove("pan"), "servo-dead"),
        ("row", remove("row"), "row-unclear"),
    ],
)
def test_a_device_without_wires_is_dead(device: str, change: Change, kind: str, tmp_path: Path) -> None:
    with open_test(tmp_path, device, truth=change) as test:
        assert kinds(test) == {device: [kind]}


NAMES = ("go", "front", "horn", "spot", "lamp", "pan", "row", "gyro")


def test_what_no_person_sees_or_does_is_not_tested(tmp_path: Path) -> None:
    with open_test(tmp_path, *NAMES, has_truth=False) as test:
        assert kinds(test) == {name: ["not-tested"] for name in NAMES}


def narrow(robot: Table) -> None:
    next(each for each in robot["devices"] if each["name"] == "pan")["min_angle_rad"] = -0.8
    robot[SECTION]["pan"] |= {"min_pulse_s": 0.0011667}


@pytest.mark.slow
def test_a_servo_that_stops_before_its_limit_gets_a_narrower_range(tmp_path: Path) -> None:
    with open_test(tmp_path, "pan", truth=narrow) as test:
        assert kinds(test) == {"pan": ["servo-angles", "servo-limit"]}
        assert test._corrections.values == {"pan": {"min_angle_rad": -0.8}}
        assert test._corrections.tables["pan"]["min_pulse_s"] == pytest.approx(0.0011667, abs=2e-6)
        assert not test.has_uncorrected_errors


@pytest.mark.slow
def test_the_limit_of_a_servo_stays_if_no_setting_corrects_its_pulses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("drivers.raspberrypi.servos.PulseDriver.correct", lambda *_: None)
    with open_test(tmp_path, "pan", truth=narrow) as test:
        assert kinds(test) == {"pan": ["servo-angles", "servo-limit"]}
        assert (test._corrections.values, test._corrections.tables) == ({}, {})
        assert test.has_uncorrected_errors


def test_a_servo_that_turns_the_wrong_way_gets_swapped_pulses(tmp_path: Path) -> None:
    wrong = set_values("pan", min_pulse_s=0.002, max_pulse_s=0.001)
    with open_test(tmp_path, "pan", wrong=wrong) as test:
        assert kinds(test) == {"pan": ["servo-reversed"]}


def test_a_person_measures_the_angles_of_a_servo(tmp_path: Path) -> None:
    person = ScriptedPerson({"pan.angle0": 20.0, "pan.angle-34": -14.0, "pan.angle34": 54.0})
    with open_test(tmp_path, "pan", person=person, has_truth=False) as test:
        assert kinds(test) == {"pan": ["servo-angles"]}


def test_a_person_names_the_colours_of_a_light(tmp_path: Path) -> None:
    answers = {"lamp.off": "n", "lamp.red": "g", "lamp.green": "r", "lamp.blue": "b"}
    with open_test(tmp_path, "lamp", person=ScriptedPerson(answers), has_truth=False) as test:
        assert kinds(test) == {"lamp": ["light-order"]}
        assert test._corrections.tables["lamp"]["red"] == 13


def test_a_camera_without_a_red_ball_in_view_is_not_tested(tmp_path: Path) -> None:
    def turn_away(robot: Table) -> None:
        next(each for each in robot["devices"] if each["name"] == "eye")["mount"]["yaw_rad"] = 2.0

    with open_test(tmp_path, "eye", truth=turn_away) as test:
        assert kinds(test) == {"eye": ["not-tested"]}


def test_a_range_sensor_that_reads_too_much_is_wrong(tmp_path: Path) -> None:
    def shift(robot: Table) -> None:
        next(each for each in robot["devices"] if each["name"] == "nose")["offset_m"] = -0.3

    with open_test(tmp_path, "nose", truth=shift) as test:
        assert kinds(test) == {"nose": ["range-wrong"]}


def test_a_kind_without_a_test_is_read_or_named(tmp_path: Path) -> None:
    with open_test(tmp_path, "screen") as test:
        assert kinds(test) == {"screen": ["not-tested"]}


def test_a_third_kind_brings_its_own_test(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    from robotcore.hal.kind import load_kind

    def test_horns(test: Any, horns: Any) -> None:
        for horn in horns:
            test.confirm(horn.name, "is a horn", "horn")

    own = replace(load_kind("buzzer"), test_devices=test_horns)
    monkeypatch.setattr("robotcore.device_test.live_device_test.load_kind", lambda _name: own)
    with open_test(tmp_path, "horn") as test:
        assert kinds(test) == {"horn": ["horn"]}
