"""What every driver with a physics engine is held to, beyond the kit's rules."""

import pytest

pytest.register_assert_rewrite("tests.drivers.physics.driving", "tests.drivers.physics.ranging")
