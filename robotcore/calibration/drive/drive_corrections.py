"""The corrections of a robot's file that follow from the measured geometry."""

from __future__ import annotations

from robotcore.calibration.corrections import Correction
from robotcore.calibration.drive.measurement import DriveResult
from robotcore.description import Drive, SkidDrive

LEAST_SHARE = 0.002
"""A length is not corrected for a smaller share, because a person or a gyroscope does not measure better."""


def list_drive_corrections(result: DriveResult, drive: Drive) -> list[Correction]:
    """Return the lengths of ``[drive]`` in the robot's file, with the measured ones."""
    place = ("drive",)
    radius = drive.wheel_radius_m
    corrections = [Correction(place, "wheel_radius_m", radius, result.radius, LEAST_SHARE * radius)]
    if result.track is None:
        return corrections
    if isinstance(drive, SkidDrive):
        factor = result.track.scale(1 / drive.track_m)
        least = LEAST_SHARE * drive.track_factor
        return [*corrections, Correction(place, "track_factor", drive.track_factor, factor, least)]
    return [*corrections, Correction(place, "track_m", drive.track_m, result.track, LEAST_SHARE * drive.track_m)]
