"""The whole sketch, compiled for an ATmega328P."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from robotcore.errors import FirmwareError
from tests.system.firmware.build import build, has_avr_gcc
from tests.texts import CheckText

pytestmark = pytest.mark.skipif(not has_avr_gcc(), reason="needs gcc-avr and arduino-core-avr")


@pytest.mark.slow
def test_sketch_compiles_without_a_warning(tmp_path: Path) -> None:
    assert build(tmp_path).read_bytes()[:4] == b"\x7fELF"


@pytest.mark.slow
def test_mistakes_in_config_h_are_compiler_errors_by_macro(tmp_path: Path, check_text: CheckText) -> None:
    wrong = {"LEFT_ENABLE_PIN": "3", "LEFT_FORWARD_PIN": "99", "SONAR_ECHO_PIN": "A4", "BATTERY_PIN": "13", "KO": "0"}
    with pytest.raises(FirmwareError) as caught:
        build(tmp_path, wrong)
    assert (caught.value.kind, caught.value.fields["tool"]) == ("tool-failed", "avr-g++")
    check_text("\n".join(sorted(set(re.findall(r"config\.h: [^ \"\n][^\"\n]*", str(caught.value))))))
