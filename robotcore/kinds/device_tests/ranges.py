"""Tests range sensors: whether each measures, and whether it is the one in the file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any

from robotcore.hal.device_test import DeviceTest
from robotcore.raycast import FAN_SETBACK_M, Fan

HELD_M = (0.08, 0.45)
"""The range of distances in which the person holds a flat thing, in metres."""

READ_S = 1.0
"""The time for which a sensor is read, in seconds."""

MAX_ERROR_M, MAX_ERROR_SHARE = 0.06, 0.08
"""The greatest error of a distance that counts as right, in metres and as a share of it."""


def test_ranges(test: DeviceTest, sensors: Sequence[Any]) -> None:
    """Compare the distances with the true ones, or with those at which the person holds a flat thing."""
    find = _compare_with_truth if test.state else _hold_before
    source: dict[str, str] = {}
    for sensor in sensors:
        found = find(test, sensor, sensors)
        if found:
            source[sensor.name] = found
    swapped = {name: other for name, other in source.items() if name != other}
    if swapped and set(swapped) == set(swapped.values()):
        text = ", ".join(f"{other} measures for {name}" for name, other in swapped.items())
        test.swap_tables(swapped, text, remedy="Swap their wires", kind="ranges-swapped")
        return
    for name, other in swapped.items():
        text, remedy = f"{other} measures in its place", f"Correct the pins of {name} and {other}"
        test.fail(name, text, remedy, "range-on-other-pins")


def _compare_with_truth(test: DeviceTest, sensor: Any, sensors: Sequence[Any]) -> str | None:
    readings, true = _read(test, sensors), _measure_truth(test, sensor.name)
    if true is None:
        test.skip(sensor.name, "the true robot has no such sensor")
        return None
    if true > sensor.max_range_m:
        test.skip(sensor.name, "nothing is in its range in the simulated world. Use --world bench")
        return None
    limit = max(MAX_ERROR_M, MAX_ERROR_SHARE * true)
    fitting = [name for name, reading in readings.items() if abs(reading - true) <= limit]
    return _report(test, sensor.name, fitting, readings[sensor.name], f"{true:.2f} m")


def _hold_before(test: DeviceTest, sensor: Any, sensors: Sequence[Any]) -> str | None:
    before = _read(test, sensors)
    low, high = HELD_M
    place = f"{low + 0.1:.1f} to {high - 0.05:.1f} m before {sensor.name}"
    text = f"Hold something flat {place}, and nothing before the others"
    if not test.instruct(sensor.name, "hold", text):
        if math.isfinite(before[sensor.name]):
            test.confirm(sensor.name, f"reads {before[sensor.name]:.2f} m; no person has held anything before it")
        else:
            test.skip(sensor.name, "it reads that nothing is in range, and no person holds anything before it")
        return None
    readings = _read(test, sensors)
    fitting = [
        name for name, reading in readings.items() if low <= reading <= high and _has_changed(before[name], reading)
    ]
    fitting = fitting or [name for name in (sensor.name,) if low <= readings[name] <= high]
    return _report(test, sensor.name, fitting, readings[sensor.name], f"{low:g} to {high:g} m")


def _has_changed(before: float, now: float) -> bool:
    return not math.isfinite(before) or abs(now - before) > MAX_ERROR_M


def _report(test: DeviceTest, name: str, fitting: Sequence[str], reading: float, expected: str) -> str | None:
    if name in fitting:
        test.confirm(name, f"reads {reading:.2f} m, which is right")
        return name
    if fitting:
        return fitting[0]
    measured = f"reads {reading:.2f} m" if math.isfinite(reading) else "has no echo"
    remedy = "Check its wires and its supply, and that nothing is in its cone"
    test.fail(name, f"{measured}, and the distance is {expected}", remedy, "range-wrong")
    return None


def _measure_truth(test: DeviceTest, name: str) -> float | None:
    state = test.state
    assert state
    for truth in state.robot.all_of("range_sensor"):
        if truth.name == name:
            fan = Fan(truth.cone_rad, 0.0, truth.max_range_m)
            start, directions = fan.rays(state.joints.locate(truth.mount))
            return fan.reading(state.cast(start, directions, truth.max_range_m + 2 * FAN_SETBACK_M))
    return None


def _read(test: DeviceTest, sensors: Sequence[Any]) -> Mapping[str, float]:
    """Return the median distance of each sensor, in metres."""
    devices: dict[str, Any] = {sensor.name: test.robot[sensor.name] for sensor in sensors}
    readings: dict[str, list[float]] = {name: [] for name in devices}

    def add_samples() -> None:
        for name, device in devices.items():
            readings[name].append(device.read().distance)

    test.repeat(add_samples, READ_S)
    return {name: median(distances) for name, distances in readings.items()}
