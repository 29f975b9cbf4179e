"""Whether what a robot's file says of its devices can be, for backends whose section has a driver for each."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

from robotcore.description import RobotDescription
from robotcore.doctor.finding import Finding
from robotcore.errors import DescriptionError
from robotcore.hardware import Fitting


def described(
    robot: RobotDescription,
    fit: Callable[[], Sequence[Fitting]],
    counted: Callable[[Sequence[Fitting]], str],
) -> Generator[Finding, None, Sequence[Fitting] | None]:
    """Yield what is wrong with the file, or that it is right, how much it has, and what of it may do harm.

    Returns the devices as they are fitted, None where the file is wrong.
    """
    try:
        fittings = fit()
    except DescriptionError as error:
        for each in (error, *error.others):
            yield Finding.error("robot", f"{each.key}: {each.fault}", each.remedy)
        return None
    yield Finding.ok("robot", f"{robot.file or robot.name} OK, {counted(fittings)}")
    for fitting in fittings:
        for warning in fitting.warnings:
            said, _, remedy = warning.partition(". ")
            yield Finding.warning("robot", f"{fitting.name}: {said}", remedy)
    return fittings
