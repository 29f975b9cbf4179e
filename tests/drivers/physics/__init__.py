"""Tests for every driver with a physics engine, in addition to the conformance kit."""

import pytest

for rules in ("driving", "ranging", "seeing"):
    pytest.register_assert_rewrite(f"{__name__}.{rules}")
