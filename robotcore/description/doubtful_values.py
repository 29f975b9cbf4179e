"""Finds values in the file of a robot or a world that are permitted but doubtful, such as lengths in centimetres."""

from __future__ import annotations

import math
from collections.abc import Iterator

from robotcore.description.drive import TwoWheelDrive
from robotcore.description.robot import GUARD_MARGIN_M, RobotDescription
from robotcore.description.types import MIN_METRES
from robotcore.description.world import WorldDescription

MAX_LENGTH_M = 3.0
"""A body that is longer or wider is doubtful, in metres."""

DENSITY_KG_M3 = 8000.0
"""A body with a greater density is doubtful, because that of steel is lower."""

REACH = 3.0
"""A part that is farther from the middle of the body is doubtful, as a multiple of the body's greatest size."""

MAX_SPEED_M_S = 5.0
"""A robot whose wheels can drive faster is doubtful, in m/s."""

DEFAULT_RATE_HZ = 20.0
"""The rate of a sensor without ``rate_hz``: a sample in each tick of a run without --rate."""

MAX_LOSS = 0.5
"""A range sensor that loses a greater share of its echoes is doubtful."""

METRES = "Give lengths in metres"


def find_doubtful_values(robot: RobotDescription) -> Iterator[str]:
    """Yield a warning for each doubtful value: its key, the problem, and a sentence with the remedy."""
    body = robot.body
    longest = max(body.length_m, body.width_m)
    if longest > MAX_LENGTH_M:
        yield f"body: it is {body.length_m:g} m long and {body.width_m:g} m wide. {METRES}"
    density = body.mass_kg / (body.length_m * body.width_m * body.height_m)
    if density > DENSITY_KG_M3:
        yield f"body.mass_kg: with {body.mass_kg:g} kg, the body is denser than steel. Give the mass in kg"
    reach, middle = REACH * max(longest, body.height_m), body.middle_m
    places = {f"{name}.mount": (mount.x_m, mount.y_m, mount.z_m) for name, mount in robot.mounts.items()}
    if isinstance(robot.drive, TwoWheelDrive) and (caster := robot.drive.caster):
        places["drive.caster.x_m"] = (caster.x_m, 0.0, 0.0)
    for key, place in places.items():
        distance = max(abs(each - centre) for each, centre in zip(place, middle, strict=True))
        if distance > reach:
            yield f"{key}: it is {distance:.2g} m from the middle of the body. {METRES}"
    yield from _find_wrong_units(robot)
    yield from _find_unusable_sensors(robot)


def _find_unusable_sensors(robot: RobotDescription) -> Iterator[str]:
    for device in robot.devices:
        rate_hz: float = getattr(device, "rate_hz", None) or math.inf
        latency_s: float = getattr(device, "latency_s", 0.0)
        if latency_s + 1 / rate_hz >= robot.safety.max_age_s:
            key, value = ("latency_s", f"{latency_s:g} s") if latency_s else ("rate_hz", f"{rate_hz:g} Hz")
            remedy = "Lower it, or raise max_age_s" if latency_s else "Raise one of them"
            yield (
                f"{device.name}.{key}: with {value}, its samples are older than safety.max_age_s, "
                f"{robot.safety.max_age_s:g} s, so each run stops. {remedy}"
            )
    for sensor in robot.all_of("range_sensor"):
        if sensor.loss > MAX_LOSS:
            yield f"{sensor.name}.loss: it loses more than half of its echoes. Check the sensor and its mount"
        # A run reads at most one sample in a tick.
        rate_hz = min(sensor.rate_hz or DEFAULT_RATE_HZ, DEFAULT_RATE_HZ)
        silence_s = sensor.latency_s + sensor.echo_free_samples / rate_hz
        if sensor.loss and silence_s >= robot.safety.max_age_s:
            yield (
                f"{sensor.name}.loss: with {sensor.loss:g}, {sensor.echo_free_samples} samples in a row without an "
                f"echo show that nothing is in range. They take {silence_s:.2g} s, and safety.max_age_s is "
                f"{robot.safety.max_age_s:g} s, so a run stops when the way becomes free. Raise max_age_s, or use a "
                "sensor that loses fewer echoes"
            )
    for sensor in robot.sensors_ahead:
        # A sensor that reads too much returns inf for a body that is nearer than its maximum.
        farthest_m: float = getattr(sensor, "max_range_m", math.inf) - max(getattr(sensor, "offset_m", 0.0), 0.0)
        if robot.safety.stop_distance_m > farthest_m:
            yield (
                f"safety.stop_distance_m: {robot.safety.stop_distance_m:g} m is beyond the range of {sensor.name}, "
                f"{farthest_m:g} m. Lower it"
            )
        nearest_m = sensor.find_nearest_ahead(robot.mounts[sensor.name], robot.body.front_x_m)
        if nearest_m > max(0.0, robot.safety.stop_distance_m - GUARD_MARGIN_M):
            yield (
                f"safety.stop_distance_m: {sensor.name} measures no distance ahead below {nearest_m:.2g} m, so the "
                f"range guard stops the robot at {nearest_m + GUARD_MARGIN_M:.2g} m in place of "
                f"{robot.safety.stop_distance_m:g} m. Lower min_range_m of {sensor.name} if the sensor can measure "
                "nearer, or raise stop_distance_m"
            )


def _find_wrong_units(robot: RobotDescription) -> Iterator[str]:
    for name, mount in robot.mounts.items():
        if abs(mount.pitch_rad) > math.pi / 2:
            pitch = f"{mount.pitch_rad:g} rad is {math.degrees(mount.pitch_rad):.0f}°"
            yield f"{name}.mount.pitch_rad: {pitch}, so it looks backwards. Give angles in radians"
    if drive := robot.drive:
        for motor in robot.all_of("motor"):
            speed = motor.max_velocity_rad_s * drive.wheel_radius_m
            if motor.name in drive.motor_by_device and speed > MAX_SPEED_M_S:
                fast = f"{motor.max_velocity_rad_s:g} rad/s drives the robot at {speed:.2g} m/s"
                yield f"{motor.name}.max_velocity_rad_s: {fast}. Give rad/s: one revolution per minute is 0.105 rad/s"


def find_bodies_outside(world: WorldDescription) -> Iterator[str]:
    """Yield a warning for the picture and each obstacle, target and line that is partly outside of the floor."""
    x_limit, y_limit = world.floor.length_m / 2, world.floor.width_m / 2
    for body in world.bodies:
        if any(abs(x) > x_limit or abs(y) > y_limit for x, y in body.outline):
            yield f"{body.name}: it is partly outside of the floor. Move it, or check its size. {METRES}"
    if (image := world.floor.image) and any(
        abs(side) > limit + MIN_METRES for side, limit in zip(image.limits, (x_limit, y_limit) * 2, strict=True)
    ):
        yield f"floor.image: it is partly outside of the floor. Move it, or check its size. {METRES}"
    for number, line in enumerate(world.lines, start=1):
        if any(abs(x) > x_limit or abs(y) > y_limit for x, y in line.points_m):
            yield f"lines[#{number}]: it is partly outside of the floor. Move it. {METRES}"
