from __future__ import annotations

from pathlib import Path

import pytest

from robotcore.calibration.corrections import Correction, apply_corrections
from robotcore.calibration.least_squares import Estimate
from robotcore.description import load_robot, read_shipped
from robotcore.description.editing import RobotEditor


@pytest.mark.parametrize(
    "old, measured, least, is_needed",
    [
        (14.0, Estimate(14.01, 0.01), 0.0, False),  # within two deviations
        (14.0, Estimate(14.03, 0.01), 0.0, True),
        (14.0, Estimate(14.01, 1e-6), 0.0, False),  # less than a thousandth
        (0.10, Estimate(0.104, 1e-6), 0.005, False),
        (0.10, Estimate(0.106, 1e-6), 0.005, True),
    ],
)
def test_a_value_is_corrected_if_it_differs_by_more_than_the_measurement(
    old: float, measured: Estimate, least: float, is_needed: bool
) -> None:
    assert Correction(("drive",), "track_m", old, measured, least).is_needed is is_needed


def test_an_exact_correction_is_not_rounded() -> None:
    correction = Correction(
        ("devices", "left_motor"), "max_velocity_rad_s", 12.0, Estimate(11.987654, 0.0), is_exact=True
    )
    assert (correction.new, correction.is_needed, correction.name) == (11.987654, True, "left_motor.max_velocity_rad_s")


def test_needed_corrections_are_written_to_their_tables(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(read_shipped("rover"), encoding="utf-8")
    editor = RobotEditor(str(file))
    apply_corrections(
        editor,
        [
            Correction(("drive",), "track_m", 0.155, Estimate(0.15, 1e-4)),
            Correction(("devices", "left_motor"), "lag_s", 0.05, Estimate(0.07, 1e-3)),
            Correction(("raspberrypi", "left_motor", "model"), "dead_band", 0.1, Estimate(0.13, 1e-3)),
            Correction(("raspberrypi", "left_motor"), "frequency_hz", 100, Estimate(200, 0.0), is_exact=True),
            Correction(("drive",), "wheel_radius_m", 0.0325, Estimate(0.0325, 1e-4)),
        ],
    )
    editor.write()
    robot = load_robot(str(file))
    left = robot.backends["raspberrypi"]["left_motor"]
    assert robot.drive
    assert (robot.drive.track_m, robot.first_of("motor").lag_s) == (0.15, 0.07)
    assert (left["model"]["dead_band"], left["model"]["forward_rad_s"], left["frequency_hz"]) == (0.13, 14.0, 200)
