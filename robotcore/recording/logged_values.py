"""The channels of the values that an app logged.

Each name has a channel ``/log/NAME`` of JSON messages, which Foxglove plots. Its schema names the type of the value.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from robotcore.hal.value_log import MAX_TEXT_LENGTH, LoggedValue, is_log_name, is_log_unit
from robotcore.recording.channel_output import ChannelOutput
from robotcore.recording.codec import from_json, name_schema, to_json
from robotcore.recording.foxglove_channels import LOG, to_nanoseconds
from robotcore.runtime.trace import TickRecord

LOGGED = "logged"
"""The key in a channel's metadata that has the name of the logged value."""


class LoggedNumber(NamedTuple):
    """The message of a logged number."""

    tick: int
    """The number of the tick."""
    value: int | float
    unit: str = ""


class LoggedBoolean(NamedTuple):
    """The message of a logged boolean."""

    tick: int
    """The number of the tick."""
    value: bool
    unit: str = ""


class LoggedText(NamedTuple):
    """The message of a logged text."""

    tick: int
    """The number of the tick."""
    value: str
    unit: str = ""


LoggedMessage = LoggedNumber | LoggedBoolean | LoggedText

_SCHEMAS = {
    kind: name_schema(kind.__name__, tick=int, value=value, unit=str)
    for kind, value in ((LoggedNumber, float), (LoggedBoolean, bool), (LoggedText, str))
}
_KINDS: dict[str, type[LoggedMessage]] = {schema["title"]: kind for kind, schema in _SCHEMAS.items()}


class LoggedValueWriter:
    """Writes the values that an app logged. The channel of a name opens with its first value."""

    def __init__(self, file: ChannelOutput) -> None:
        self._file = file
        self._channels: dict[str, Callable[[bytes, int], None]] = {}

    def write(self, record: TickRecord) -> None:
        """Write the values of a tick."""
        for name, logged in record.logged.items():
            message = _build_message(record.tick, logged)
            if name not in self._channels:
                metadata = {LOGGED: name, "unit": logged.unit}
                self._channels[name] = self._file.open_json_channel(f"{LOG}/{name}", _SCHEMAS[type(message)], metadata)
            self._channels[name](to_json(message), to_nanoseconds(record.time))


def _build_message(tick: int, logged: LoggedValue) -> LoggedMessage:
    value, unit = logged
    if isinstance(value, bool):
        return LoggedBoolean(tick, value, unit)
    return LoggedText(tick, value, unit) if isinstance(value, str) else LoggedNumber(tick, value, unit)


def parse_logged(name: str, schema: str, content: bytes) -> LoggedMessage:
    """Parse a logged value. Raises ValueError if no app can have logged it.

    name: the name of the value.
    schema: the name of the channel's schema.
    """
    if not is_log_name(name) or schema not in _KINDS:
        raise ValueError("a channel of logged values has an invalid name or schema")
    message = from_json(_KINDS[schema], content)
    if not is_log_unit(message.unit):
        raise ValueError(f"the unit of the logged value {name} is invalid")
    if isinstance(message.value, str) and len(message.value) > MAX_TEXT_LENGTH:
        raise ValueError(f"the logged value {name} is longer than {MAX_TEXT_LENGTH} characters")
    return message
