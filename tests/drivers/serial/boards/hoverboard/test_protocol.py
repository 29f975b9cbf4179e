"""Frames of the firmware's own structs, compiled from its source and recorded once."""

from __future__ import annotations

from itertools import product

import pytest

from drivers.serial.boards.hoverboard.protocol import (
    Feedback,
    Mixer,
    Parser,
    SteerCommand,
    build_command,
)
from tests.doubles.serial.hoverboard import feedback

COMMANDS = {
    (0, 0): "cdab00000000cdab",
    (100, -200): "cdab640038ff9154",
    (-1, 1): "cdabffff01003354",
}

STANDING = bytes.fromhex("cdab00000000d8ff2800d40e2c010000c55b")
TURNING = bytes.fromhex("cdab640038fffa00ceffac0ff1ff0300fb5b")
FEEDBACK = {
    STANDING: Feedback(0, 0, -40, 40, 37.96),
    TURNING: Feedback(100, -200, 250, -50, 40.12),
}


def test_commands_are_frames_of_the_firmware() -> None:
    for words, frame in COMMANDS.items():
        assert build_command(*words).hex() == frame, words


def test_feedback_is_parsed_from_frames_of_the_firmware() -> None:
    for frame, content in FEEDBACK.items():
        assert Parser().feed(frame) == [content], frame


@pytest.mark.parametrize(
    "words",
    [(1600, 0, 0, 0, 3700, 300, 0), (0, 0, 0, -2100, 3700, 300, 0), (0, 0, 0, 0, -1, 300, 0), (0, 0, 0, 0, 0, 0, 256)],
    ids=["input", "speed", "voltage", "lamps"],
)
def test_impossible_values_are_dropped_despite_a_right_checksum(words: tuple[int, ...]) -> None:
    assert Parser().feed(feedback(*words)) == []


MADE = """\
16384 8192 200 0 200 200
16384 8192 0 200 100 -100
16384 8192 101 1 101 100
16384 8192 -101 1 -101 -102
16384 8192 -333 -777 -722 55
16384 8192 1000 1000 1000 500
16384 8192 1000 -1000 500 1000
24000 3000 200 0 292 292
24000 3000 0 200 36 -37
24000 3000 101 1 148 147
24000 3000 -101 1 -148 -149
24000 3000 -333 -777 -631 -346
24000 3000 1000 1000 1000 1000
24000 3000 1000 -1000 1000 1000"""
"""SPEED_COEFFICIENT and STEER_COEFFICIENT, speed and steer, and the result of mixerFcn: left and right."""


def test_mixer_is_the_firmwares() -> None:
    for line in MADE.splitlines():
        speed_coefficient, steer_coefficient, speed, steer, left, right = map(int, line.split())
        mixer = Mixer(speed_coefficient / 16384, steer_coefficient / 16384)
        assert mixer.wheels(SteerCommand(steer, speed)) == (left, right), line


def test_every_reachable_pair_of_wheels_is_exact_with_default_coefficients() -> None:
    mixer = Mixer()
    some = (*range(-1000, 1001, 137), -1, 0, 1, 2)
    for left, right in product(some, some):
        if abs(left - right) <= 1000:
            assert mixer.wheels(mixer.steering(left, right)) == (left, right)


@pytest.mark.parametrize("mixer", [Mixer(0.9, 0.5), Mixer(1.7, 0.3), Mixer(0.4, 0.2)], ids=str)
def test_with_other_coefficients_no_nearby_command_has_a_smaller_error(mixer: Mixer) -> None:
    for left, right in product(range(-173, 174, 43), repeat=2):
        steer, speed = mixer.steering(left, right)
        near = (SteerCommand(steer + by, speed + more) for by, more in product(range(-2, 3), repeat=2))
        assert _error(mixer, SteerCommand(steer, speed), left, right) == min(
            _error(mixer, steering, left, right) for steering in near
        )


MIXERS: tuple[Mixer, ...] = (Mixer(), Mixer(0.9, 0.4), Mixer(is_tank=True))


def test_wheels_beyond_the_reach_keep_their_path() -> None:
    for case in product(MIXERS, [(1000, -1000), (1000, -200), (1800, 600), (-2000, 1000), (0, 1000)]):
        mixer, wheels = case
        steering = mixer.steering(*wheels)
        left, right = mixer.wheels(steering)
        assert max(map(abs, steering)) <= 1000, case
        assert left * wheels[1] == pytest.approx(right * wheels[0], abs=sum(map(abs, wheels))), case
        assert max(abs(left), abs(right)) >= 390, case


def _error(mixer: Mixer, steering: SteerCommand, left: int, right: int) -> int:
    made_left, made_right = mixer.wheels(steering)
    return (made_left - left) ** 2 + (made_right - right) ** 2
