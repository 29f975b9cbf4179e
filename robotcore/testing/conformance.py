"""The conformance kit: one class with the tests of all rules for drivers."""

from __future__ import annotations

import pytest

from robotcore.testing.camera_rules import CameraRules
from robotcore.testing.cutoff_rules import CutoffRules
from robotcore.testing.device_rules import DisplayRules, EncoderRules
from robotcore.testing.kind_rules import KindRules
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
    CutoffRules,
    EncoderRules,
    RangeRules,
    CameraRules,
    SampleRules,
    DisplayRules,
    KindRules,
    TruthRules,
    RepeatRules,
):
    """The tests of all rules for drivers. The name of a test states its rule.

    Derive a class with a name such as ``TestMyBoard`` from it in a test module, and set ``backend``. `TestBench`
    documents the other attributes and the methods to override. pytest lists the skipped rules at the end, each with its
    reason. Its last line warns if nothing measures the robot's motion.

    >>> from robotcore.testing.mock.backend import MockBackend
    >>> class TestMock(ConformanceSuite):
    ...     backend = MockBackend
    >>> TestMock().test_equal_runs_read_equal_samples()
    """
