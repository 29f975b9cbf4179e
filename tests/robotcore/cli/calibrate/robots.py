"""Files of a rover and of the true rover, which differs from its file."""

from __future__ import annotations

from pathlib import Path

from robotcore.description import read_shipped

MODEL = "{ dead_band = 0.10, forward_rad_s = 14.0, backward_rad_s = 14.0 }"
IMU = '[[devices]]\nkind = "imu"\nname = "gyro"\n\n[raspberrypi.gyro]\ndriver = "mpu6050"\n'

Changes = tuple[tuple[str, str], ...]


def write_robot(folder: Path, name: str, *changes: tuple[str, str], more: str = "") -> str:
    """Write a rover's file with replaced texts and with ``more`` at its end, and return its path."""
    text = read_shipped("rover")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    file = folder / f"{name}.toml"
    file.write_text(text + more, encoding="utf-8")
    return str(file)


OTHER_MOTORS: Changes = (
    (
        f"standby = 22\nmodel = {MODEL}\n\n[raspberrypi.right",
        "standby = 22\nmodel = { dead_band = 0.16, forward_rad_s = 12.9, backward_rad_s = 13.6 }\n\n[raspberrypi.right",
    ),
    (f"model = {MODEL}", "model = { dead_band = 0.12, forward_rad_s = 14.4, backward_rad_s = 15.2 }"),
    ("lag_s = 0.05", "lag_s = 0.08"),
)
DEAD_ENCODER: Changes = (("[raspberrypi.left_encoder]", "[vrep.unconnected]"),)
REVERSED_ENCODER: Changes = (("a = 5\nb = 6", "a = 6\nb = 5"),)
SLOW_LEFT_MOTOR: Changes = (
    (
        'name = "left_motor"\nmax_velocity_rad_s = 12.0\nlag_s = 0.05',
        'name = "left_motor"\nmax_velocity_rad_s = 12.0\nlag_s = 0.15',
    ),
)
ARDUINO_MOTORS: Changes = tuple(
    (
        f'driver = "h-bridge"\nforward = {forward}\nbackward = {backward}\nstandby = 22\nmodel = {MODEL}\n',
        f'driver = "ros-arduino-motor"\nport = "/dev/ttyACM0"\nside = "{side}"\nmodel = {MODEL}\n',
    )
    for side, forward, backward in (("left", 17, 27), ("right", 23, 24))
)
NO_ENCODERS: Changes = tuple(
    change
    for side, pins in (("left", "a = 5\nb = 6"), ("right", "a = 20\nb = 21"))
    for change in (
        (f'[[devices]]\nkind = "encoder"\nname = "{side}_encoder"\ncounts_per_turn = 960\n', ""),
        (f'{side}_encoder = "{side}_encoder"\n', ""),
        (f'[raspberrypi.{side}_encoder]\ndriver = "quadrature"\n{pins}\n', ""),
    )
)
