from __future__ import annotations

import pytest

from robotcore.errors import UsageError
from robotcore.runtime.faults import Spec


@pytest.mark.parametrize(
    "text, canonical",
    [
        ("camera drop=0.2", "camera drop=0.2"),
        ("  camera   drop=.20\tlasts=3.0  after=5e0 ", "camera drop=0.2 after=5 lasts=3"),
        ("range no-echo=0.5", "range no_echo=0.5"),
        ("camera freeze", "camera freeze"),
        ("camera fog=thick", "camera fog=thick"),
        ("loop stall=0.1 every=1_0", "loop stall=0.1 every=10"),
    ],
)
def test_the_canonical_form_is_read_as_the_same(text: str, canonical: str) -> None:
    assert str(Spec.parse(text)) == canonical
    assert Spec.parse(canonical) == Spec.parse(text)


@pytest.mark.parametrize(
    "text, fault",
    [
        ("", "everything is missing"),
        ("camera", "an effect is missing"),
        ("camera drop=0.2 after", "'after' has no value"),
        ("camera drop= after=5", "'drop=' has no value"),
        ("camera =0.2", "'' is no name"),
        ("ca/mera drop=0.2", "'ca/mera' is no name"),
        ("camera drop=0.2 after=5 after=6", "after is given twice"),
        ("camera drop=0.2\x07", r"'0.2\\x07' cannot be printed"),
    ],
)
def test_what_is_none_is_told_in_one_line_with_the_form(text: str, fault: str) -> None:
    with pytest.raises(UsageError, match=fault) as raised:
        Spec.parse(text)
    assert 'Write TARGET EFFECT[=VALUE] [KEY=VALUE …], such as "camera drop=0.2 after=5"' in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_long_text_is_not_told_in_full() -> None:
    with pytest.raises(UsageError) as raised:
        Spec.parse("x" * 10_000)
    assert len(str(raised.value)) < 250
