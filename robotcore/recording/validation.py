"""Parse the JSON messages of a recording, and check that they describe a possible run.

Each function raises ValueError if a message is malformed or impossible, such as a tick before the previous one. Samples
and commands may have any value: a driver may return NaN, and the recording must show it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sized
from dataclasses import MISSING, dataclass, fields
from functools import cache
from typing import Any, get_type_hints

from pydantic import BaseModel, ValidationError, create_model

from robotcore.compatibility import PACKAGE, is_newer, read_version
from robotcore.errors import BackendError, DeviceError, Interrupted, RobotcoreError, SafetyStop, UsageError
from robotcore.hal.device import Sample, list_values
from robotcore.hal.kind import Kind
from robotcore.plugins import kind_names
from robotcore.recording.codec import from_json
from robotcore.recording.events import RecordedError, Tick
from robotcore.recording.recording import FORMAT, Metadata
from robotcore.runtime.faults.spec import Spec
from robotcore.runtime.plan import MAX_RATE_HZ, MIN_RATE_HZ
from robotcore.runtime.result import RunResult
from robotcore.text import escape

MAX_SECONDS = 1e9
"""The longest possible run, in seconds: thirty years."""

_MAX_TICKS = 2**53
_MAX_ANGLE = 1e12
_MAX_NAMES = 1000
"""The maximum number of milestones and of devices. Each becomes a row of a table."""
_DEVICE_ERRORS = (BackendError, DeviceError, SafetyStop, UsageError)
"""The base classes of the errors of devices. UsageError is that of a mock device with an invalid script."""
_FORMAT_LENGTH = 40
_KIND_LENGTH = 60
_SIGNALS = range(129, 193)
"""The exit statuses 128 + N of a process that the signal N ended."""
_BATTERY_KEYS = {"lowest_v", "last_v"}


@dataclass
class _Origin:
    """The parts of the metadata that every version of robotcore can read."""

    format: Any = FORMAT
    platform: Any = None

    @property
    def newer_version(self) -> str:
        """The version of the robotcore that wrote the file if it is newer than this one, else ``""``."""
        platform = self.platform if isinstance(self.platform, dict) else {}
        written = escape(str(platform.get(PACKAGE, ""))[:_FORMAT_LENGTH])
        return written if is_newer(written) else ""


class UnknownFormatError(ValueError):
    """The recording has a file format, or was written by a newer robotcore, that this version cannot read."""


class MissingKindError(ValueError):
    """The robot of the run has a device of a kind that no installed package registers.

    name: the name of the kind.
    """

    def __init__(self, name: str) -> None:
        super().__init__(f"the robot has a device of the kind {name!r}, which is not installed")
        self.name = name


def parse_metadata(content: bytes) -> Metadata:
    """Parse the metadata of a run.

    Raises UnknownFormatError if a later version of robotcore wrote them, and MissingKindError if a kind of the robot's
    devices is not installed.
    """
    origin = from_json(_Origin, content)
    if origin.format != FORMAT:
        written = escape(repr(origin.format)[:_FORMAT_LENGTH])
        by = f", of robotcore {origin.newer_version}" if origin.newer_version else ""
        text = f"the file has format {written}{by}, and this robotcore {read_version()} reads only {FORMAT}"
        raise UnknownFormatError(text)
    try:
        metadata = from_json(Metadata, content)
    except ValidationError as error:
        if newer := origin.newer_version:
            text = f"robotcore {newer} wrote the file, and this robotcore {read_version()} cannot read it"
            raise UnknownFormatError(text) from error
        if kind := _find_missing_kind(error):
            raise MissingKindError(kind) from error
        raise
    if not MIN_RATE_HZ <= metadata.request.rate_hz <= MAX_RATE_HZ:
        raise ValueError(f"rate_hz is {metadata.request.rate_hz:g}, outside of {MIN_RATE_HZ:g} to {MAX_RATE_HZ:g}")
    _require_seconds("timeout_s", metadata.request.timeout_s)
    _require_faults(metadata.request.faults)
    _require_few("devices", metadata.description.devices)
    return metadata


def _find_missing_kind(error: ValidationError) -> str:
    """Return the kind of the first device whose kind is not installed; ``""`` if there is none."""
    for found in error.errors(include_url=False, include_input=False):
        kind = str(found.get("ctx", {}).get("tag", ""))
        if found["type"] == "union_tag_invalid" and found["loc"][:2] == ("description", "devices") and _is_name(kind):
            return kind
    return ""


def _is_name(kind: str) -> bool:
    return kind.isidentifier() and len(kind) <= _KIND_LENGTH and kind not in kind_names()


def parse_tick(content: bytes, before: Tick | None) -> Tick:
    """Parse a tick. ``before`` is the previous tick in the file; None for the first tick."""
    tick = from_json(Tick, content)
    if not 0 <= tick.number < _MAX_TICKS or (before and tick.number != before.number + 1):
        raise ValueError(f"tick {tick.number} {f'follows tick {before.number}' if before else 'has an invalid number'}")
    _require_seconds(f"the time of tick {tick.number}", tick.time)
    if before and tick.time < before.time:
        raise ValueError(f"tick {tick.number} at {tick.time:g} s is earlier than tick {before.number}")
    for each in tick.interventions:
        _require_seconds(f"the time of an intervention in tick {tick.number}", each.time)
    for turned in tick.turned:
        for wheels in (turned.angles or (), *turned.between):
            for angle in wheels:
                _require_angle(angle)
    if invalid := {error.kind for error in _list_device_errors(tick) if not _is_device_error(error)}:
        raise ValueError(f"tick {tick.number} has a device error of an unknown class: {', '.join(sorted(invalid))}")
    error = tick.error
    if error and error.kind == Interrupted.__name__ and error.attributes.get("exit_status") not in _SIGNALS:
        raise ValueError(f"tick {tick.number} has an interruption without the exit status of a signal")
    return tick


def parse_sample(kind: Kind, content: bytes) -> Sample:
    """Parse a sample of a sensor. Raises ValueError if devices of the kind have no such samples."""
    if kind.sample is None:
        raise ValueError(f"a {kind.name} has no samples")
    sample: Sample = from_json(kind.sample, content)
    for value in list_values(kind.sample):
        if value.unit == "rad":
            angles = getattr(sample, value.field)
            for angle in angles if isinstance(angles, tuple) else (angles,):
                _require_angle(angle)
    return sample


def parse_result(content: bytes) -> RunResult:
    """Parse the result of a run. Unknown keys are ignored."""
    valid = _build_result_model().model_validate_json(content)
    result = RunResult(**{name: getattr(valid, name) for name in valid.model_fields_set})
    times = {"sim_time_s": result.sim_time_s, "wall_time_s": result.wall_time_s}
    for kind, named in (("milestone", result.milestones), ("intervention", result.intervention_s)):
        _require_few(f"{kind}s", named)
        times |= {f"the time of {kind} {name!r}": time for name, time in named.items()}
    for name, time in times.items():
        _require_seconds(name, time)
    for name, voltages in result.batteries.items():
        if missing := _BATTERY_KEYS - voltages.keys():
            raise ValueError(f"{', '.join(sorted(missing))} of battery {name!r} is missing")
    _require_faults(result.faults)
    return result


@cache
def _build_result_model() -> type[BaseModel]:
    """Return a model with the fields of a result but ``error``. It has no defaults of its own."""
    kinds = get_type_hints(RunResult)
    types = {
        each.name: (kinds[each.name], ... if each.default is MISSING and each.default_factory is MISSING else None)
        for each in fields(RunResult)
        if each.name != "error"
    }
    model: type[BaseModel] = create_model("Result", **types)  # type: ignore[call-overload]  # computed fields
    return model


def _list_device_errors(tick: Tick) -> Iterator[RecordedError]:
    for events in (tick.reads, tick.asks, tick.motor_asks, tick.turned, tick.shown, tick.commands):
        yield from (event.error for event in events if event.error)
    if tick.commit_error:
        yield tick.commit_error


def _is_device_error(error: RecordedError) -> bool:
    kind = type(error.rebuild())
    return kind is RobotcoreError or issubclass(kind, _DEVICE_ERRORS)


def _require_angle(angle: float) -> None:
    if abs(angle) > _MAX_ANGLE:
        raise ValueError(f"a wheel angle of {angle:g} rad is above the limit of {_MAX_ANGLE:g} rad")


def _require_seconds(name: str, seconds: float) -> None:
    if not abs(seconds) <= MAX_SECONDS:
        raise ValueError(f"{name} is {seconds:g} s, above the limit of {MAX_SECONDS:g} s")


def _require_few(kind: str, named: Sized) -> None:
    if len(named) > _MAX_NAMES:
        raise ValueError(f"the run has {len(named)} {kind}, above the limit of {_MAX_NAMES}")


def _require_faults(faults: Any) -> None:
    for text in faults:
        if not math.isfinite(Spec.parse(text).after_s):
            raise ValueError(f"the fault {text!r} has a start time that is not finite")
