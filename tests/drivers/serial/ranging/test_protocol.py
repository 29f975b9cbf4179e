from __future__ import annotations

import pytest

from drivers.serial.ranging.protocol import Detection, Parser
from tests.doubles.serial.tfmini import DAZZLED_CM, SATURATED_CM, STRONG, WEAK, WEAK_CM, frame

TFMINI_MODE = 7
"""A mode, which a TFmini sends in place of the temperature."""

FRAMES = [
    # TFmini-S manual, 5.3: header, distance, amplitude, temperature, sum; low bytes first
    ("59 59 32 00 e8 03 c8 08 9f", Detection.TARGET, 0.50),
    ("59 59 2c 01 64 00 c8 08 13", Detection.TARGET, 3.00),
    ("59 59 ff ff 63 00 c8 08 e3", Detection.NOTHING, None),
    ("59 59 fe ff ff ff c8 08 7d", Detection.UNCLEAR, None),
    # TFmini, 5.3: a mode and a spare byte in place of the temperature
    ("59 59 d8 00 1d 00 02 00 a9", Detection.TARGET, 2.16),
    ("59 59 ff ff 13 00 07 00 ca", Detection.NOTHING, None),
    # TF-Luna, 6.8: no distance if the amplitude is too low
    ("59 59 00 00 0c 00 00 09 c7", Detection.NOTHING, None),
]


@pytest.mark.parametrize("sent, seen, distance", FRAMES)
def test_frames_are_parsed_as_in_the_manuals(sent: str, seen: Detection, distance: float | None) -> None:
    reading, _ = Parser().feed(2 * bytes.fromhex(sent))
    assert reading.detection is seen
    assert distance is None or reading.distance == distance


def test_a_distance_needs_enough_light() -> None:
    for sent, seen in [
        (frame(50, 100), Detection.TARGET),
        (frame(50, 99), Detection.NOTHING),
        (frame(50, 20, TFMINI_MODE), Detection.TARGET),
        (frame(50, 19, TFMINI_MODE), Detection.NOTHING),
        (frame(0, 0xFFFF), Detection.UNCLEAR),
        (frame(50, 0xFFFF), Detection.UNCLEAR),
        (frame(WEAK_CM, 100), Detection.NOTHING),
        (frame(SATURATED_CM), Detection.UNCLEAR),
        (frame(DAZZLED_CM), Detection.UNCLEAR),
        (frame(DAZZLED_CM, WEAK), Detection.UNCLEAR),
        (frame(0), Detection.TARGET),
    ]:
        assert [reading.detection for reading in Parser().feed(2 * sent)] == [seen, seen], sent.hex()


def test_a_frame_is_accepted_at_once_after_two_in_a_row() -> None:
    parser = Parser()
    batches = [parser.feed(frame(distance)) for distance in (50, 51, 52)]
    assert [[reading.distance_cm for reading in readings] for readings in batches] == [[], [50, 51], [52]]


def test_a_frame_cut_out_of_two_equal_frames_is_rejected() -> None:
    """The checksum is right for every rotation of this frame, so the parser must reject the impossible values."""
    still = frame(0x59, 0xF805, 0x08C9)
    assert still[-1] == 0x59 + 0x80
    assert {reading.amplitude for reading in Parser().feed(still[1:] + still * 3)} == {0xF805}


def test_a_single_frame_in_noise_is_rejected() -> None:
    parser = Parser()
    assert parser.feed(b"\x00" + frame(50) + b"noise" + frame(51) + b"\x59") == []


def test_impossible_words_are_dropped() -> None:
    too_far, too_hot = frame(2001), frame(50, STRONG, 4096)
    assert Parser().feed(too_far * 3 + too_hot * 3) == []
