"""The whole kit in one class."""

from __future__ import annotations

import pytest

from robotcore.testing.camera_rules import CameraRules
from robotcore.testing.device_rules import BatteryRules, DisplayRules, EncoderRules
from robotcore.testing.lifecycle_rules import LifecycleRules
from robotcore.testing.motor_rules import MotorRules
from robotcore.testing.range_rules import RangeRules
from robotcore.testing.simulation_rules import RepeatRules, TruthRules
from robotcore.testing.time_rules import ClockRules, SampleRules


@pytest.mark.conformance
class ConformanceSuite(
    LifecycleRules,
    ClockRules,
    MotorRules,
    EncoderRules,
    RangeRules,
    CameraRules,
    BatteryRules,
    SampleRules,
    DisplayRules,
    TruthRules,
    RepeatRules,
):
    """Every rule that a driver must keep; each test's name is the rule.

    Derive from it in a test module, under a name that begins with ``Test``, and set ``backend``. See `Bench` for
    what else can be told. A rule that cannot be checked is skipped with its reason, and listed at the end.
    """
