"""The numbers of the legacy remote API: commands and operation modes.

They are the maker's: ``simConst.h`` of the remote API, version 11. Only what the double serves is named.
"""

from __future__ import annotations

from enum import IntEnum

NULL, FOUR_BYTES, EIGHT_BYTES, ONE_STRING = 0x0000, 0x1000, 0x2000, 0x3000
"""What a command is told apart by besides its number: nothing, a handle, two numbers, a name."""


class Code(IntEnum):
    """A command, without its operation mode."""

    SYNCHRONOUS_ENABLE = NULL + 1
    SYNCHRONOUS_DISABLE = NULL + 2
    SYNCHRONOUS_NEXT = NULL + 3
    GET_LAST_ERRORS = NULL + 4
    KILL_CONNECTION = NULL + 10

    GET_JOINT_POSITION = FOUR_BYTES + 1
    SET_JOINT_POSITION = FOUR_BYTES + 2
    GET_VISION_SENSOR_IMAGE_BW = FOUR_BYTES + 3
    GET_VISION_SENSOR_IMAGE_RGB = FOUR_BYTES + 4
    SET_VISION_SENSOR_IMAGE_BW = FOUR_BYTES + 5
    SET_VISION_SENSOR_IMAGE_RGB = FOUR_BYTES + 6
    START_PAUSE_STOP_SIMULATION = FOUR_BYTES + 7
    SET_JOINT_TARGET_VELOCITY = FOUR_BYTES + 8
    READ_PROXIMITY_SENSOR = FOUR_BYTES + 9
    READ_VISION_SENSOR = FOUR_BYTES + 17
    GET_OBJECT_PARENT = FOUR_BYTES + 18
    SET_OBJECT_ORIENTATION = FOUR_BYTES + 26
    SET_OBJECT_POSITION = FOUR_BYTES + 27
    GET_INTEGER_PARAMETER = FOUR_BYTES + 33
    GET_FLOATING_PARAMETER = FOUR_BYTES + 35
    SET_FLOATING_PARAMETER = FOUR_BYTES + 36

    GET_OBJECT_ORIENTATION = EIGHT_BYTES + 13
    GET_OBJECT_POSITION = EIGHT_BYTES + 14

    GET_OBJECT_HANDLE = ONE_STRING + 1
    ADD_STATUSBAR_MESSAGE = ONE_STRING + 8
    CLEAR_FLOAT_SIGNAL = ONE_STRING + 13
    CLEAR_INTEGER_SIGNAL = ONE_STRING + 14
    GET_FLOAT_SIGNAL = ONE_STRING + 16
    GET_INTEGER_SIGNAL = ONE_STRING + 17
    SET_FLOAT_SIGNAL = ONE_STRING + 19
    SET_INTEGER_SIGNAL = ONE_STRING + 20


class Mode(IntEnum):
    """An operation mode, as it is added to a command's number; ``buffer`` and ``remove`` never reach the line."""

    ONESHOT = 0x00000
    BLOCKING = 0x10000
    STREAMING = 0x20000
    ONESHOT_SPLIT = 0x30000
    STREAMING_SPLIT = 0x40000
    DISCONTINUE = 0x50000


CODE_MASK = 0xFFFF
