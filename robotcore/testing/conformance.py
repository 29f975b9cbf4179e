"""The whole kit in one class."""

from __future__ import annotations

import pytest

from robotcore.testing.battery_rules import BatteryRules
from robotcore.testing.camera_rules import CameraRules
from robotcore.testing.clock_rules import ClockRules
from robotcore.testing.display_rules import DisplayRules
from robotcore.testing.encoder_rules import EncoderRules
from robotcore.testing.lifecycle_rules import LifecycleRules
from robotcore.testing.motor_rules import MotorRules
from robotcore.testing.range_rules import RangeRules
from robotcore.testing.repeat_rules import RepeatRules
from robotcore.testing.sample_rules import SampleRules
from robotcore.testing.tick_rules import TickRules
from robotcore.testing.truth_rules import TruthRules


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
    TickRules,
    TruthRules,
    RepeatRules,
):
    """Every rule that a driver must keep; each test's name is the rule.

    Derive from it in a test module, under a name that begins with ``Test``, and set ``backend``. See `Bench` for
    what else can be told. A rule that cannot be checked is skipped with its reason, and listed at the end.
    """
