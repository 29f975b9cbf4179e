from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest

from robotcore.errors import UsageError
from robotcore.testing import ConformanceSuite
from tests.texts import CheckText, Raises

pytest_plugins = ["pytester"]

SUITE = """
from robotcore.testing import TestSupport, ConformanceSuite
from drivers.kinematic.backend import KinematicBackend

class Backend(KinematicBackend):
    modules = {modules}

class TestDriver(ConformanceSuite):
    backend = Backend
    lacks = {{TestSupport.LOST_ECHO: "the simulator cannot hide a wall"}}
"""

UNMEASURED = """
from tests.robotcore.testing.broken.unmeasured import MeasuredWithoutEncodersSuite, NoTruthSuite, UnmeasuredSuite

class TestMeasured(MeasuredWithoutEncodersSuite): ...
class TestByEncoders(NoTruthSuite): ...
"""


def run_suite(pytester: pytest.Pytester, *modules: str) -> pytest.RunResult:
    pytester.makepyfile(SUITE.format(modules=modules))
    return pytester.runpytest_inprocess("--strict-markers", "-k", "echo or hardware or wall_is_right")


@pytest.mark.parametrize(
    "attributes, kind",
    [({"backend": "kinematic"}, "suite-backend"), ({"lacks": {"WORLD": "an empty room"}}, "suite-lacks")],
)
def test_suite_with_an_invalid_attribute_is_refused(attributes: dict[str, Any], kind: str, raises: Raises) -> None:
    with raises(UsageError, kind):
        type("TestDriver", (ConformanceSuite,), attributes)


def list_unchecked(result: pytest.RunResult) -> list[str]:
    """Return the lines about rules that were not checked."""
    lines = result.outlines
    begin = next(index for index, line in enumerate(lines) if "conformance rules not checked" in line)
    return [line for line in lines[begin + 1 :] if not line.startswith("=")]


def test_rules_not_checked_are_listed_with_their_reason(pytester: pytest.Pytester, check_text: CheckText) -> None:
    result = run_suite(pytester)
    result.assert_outcomes(passed=3, skipped=6, deselected=result.parseoutcomes()["deselected"])
    assert "skipped" in result.outlines[-1]
    check_text("\n".join(list_unchecked(result)))


def test_backend_that_is_not_installed_is_skipped_with_its_remedy(
    pytester: pytest.Pytester, check_text: CheckText
) -> None:
    result = run_suite(pytester, "no_such_simulator")
    assert result.parseoutcomes()["skipped"] == 9
    check_text(list_unchecked(result)[0])


@pytest.mark.slow
@pytest.mark.parametrize("options", [("-q",), ("-n", "1")], ids=["quiet", "on a worker"])
def test_last_line_warns_of_each_suite_whose_motion_nothing_measures(
    pytester: pytest.Pytester, check_text: CheckText, options: tuple[str, ...]
) -> None:
    pytester.makepyfile(UNMEASURED + "class TestA(UnmeasuredSuite): ...\nclass TestB(UnmeasuredSuite): ...\n")
    result = pytester.runpytest_inprocess("-k", "rest or forward or reading", *options)
    assert result.ret == 0
    check_text(result.outlines[-1])


def test_nothing_is_listed_without_the_kit(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("import pytest\n\ndef test_nothing():\n    pytest.skip('not now')")
    result = pytester.runpytest_inprocess()
    assert not any("conformance" in line for line in result.outlines)


def test_module_that_is_skipped_as_a_whole_is_no_rule(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("import pytest\n\npytest.skip('not here', allow_module_level=True)")
    result = pytester.runpytest_inprocess()
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    assert not any("conformance" in line for line in result.outlines)


def test_unused_plugin_imports_nothing_heavy() -> None:
    code = "import sys, robotcore.testing.plugin; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numpy", "cv2", "pydantic", "pytest", "robotcore.devices"} & set(loaded)


def test_unknown_name_in_the_kit_is_an_attribute_error() -> None:
    from robotcore import testing

    with pytest.raises(AttributeError):
        _ = testing.ConformanceSweet
