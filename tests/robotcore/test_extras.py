"""The extras of robotcore install the modules that their features need."""

from __future__ import annotations

import re
from importlib.metadata import packages_distributions, requires

import pytest

from robotcore.extras import MODULES


@pytest.mark.parametrize("extra", MODULES)
def test_each_extra_installs_the_modules_that_its_features_need(extra: str) -> None:
    requirements = [each for each in requires("robotcore") or () if f'extra == "{extra}"' in each.replace("'", '"')]
    installed = {re.match(r"[\w.-]+", each)[0].lower() for each in requirements}  # type: ignore[index]
    distributions = packages_distributions()
    for module in MODULES[extra]:
        assert installed & {each.lower() for each in distributions[module]}, module
