import math

import pytest

from robotcore.description import RangeSensorDescription, load_robot
from robotcore.errors import DeviceError
from robotcore.hardware.polled import Findings

[NOSE] = load_robot("rover").all_of(RangeSensorDescription)


def test_before_anything_was_found_it_says_so() -> None:
    findings = Findings(NOSE, 3)
    findings.nothing(0.0)
    findings.recovered()
    assert not findings.has_told
    with pytest.raises(DeviceError, match="nose: has found nothing that could be judged"):
        findings.newest.get()


def test_a_failure_ends_a_row_of_nothing() -> None:
    findings = Findings(NOSE, 3)
    findings.found(1.0, 0.0)
    findings.nothing(0.1)
    findings.nothing(0.2)
    findings.failed(OSError("unplugged"))
    findings.recovered()
    findings.nothing(0.3)
    assert findings.newest.get().time == 0.0


def test_what_is_in_range_and_what_is_not() -> None:
    findings = Findings(NOSE, 3)
    for number, (distance, told) in enumerate([(0.0, 0.02), (0.5, 0.5), (2.0, 2.0), (2.001, math.inf)]):
        findings.found(distance, float(number))
        sample = findings.newest.get()
        assert (sample.distance, sample.time, sample.sequence) == (told, float(number), number)
