"""The conformance kit: all rules in one class."""

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
    """The tests of every rule for a driver. The name of a test states its rule.

    Derive a class from it in a test module, give it a name that begins with ``Test``, and set ``backend``. `TestBench`
    documents the other attributes. A rule that cannot be tested is skipped. The end of pytest's output lists skipped
    rules with the reason.

    >>> from robotcore.testing.mock.backend import MockBackend
    >>> class TestMock(ConformanceSuite):
    ...     backend = MockBackend
    >>> TestMock().test_equal_runs_read_equal_samples()
    """
