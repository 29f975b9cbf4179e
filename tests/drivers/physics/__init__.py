"""What every driver with a physics engine is held to, beyond the kit's rules."""

import pytest

for rules in ("driving", "ranging", "seeing"):
    pytest.register_assert_rewrite(f"{__name__}.{rules}")
