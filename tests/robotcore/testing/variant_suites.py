"""Suites for a variant of a driver: the conformance rules on which the variant has an influence.

The whole `ConformanceSuite` tests each driver once.
"""

from __future__ import annotations

import pytest

from robotcore.testing.device_rules import EncoderRules
from robotcore.testing.motor_rules import MotorRules
from robotcore.testing.range_rules import RangeRules


@pytest.mark.conformance
class DriveSuite(MotorRules, EncoderRules):
    """The rules for motors and encoders."""


class DriveAndRangeSuite(DriveSuite, RangeRules):
    """The rules for motors, encoders and range sensors."""
