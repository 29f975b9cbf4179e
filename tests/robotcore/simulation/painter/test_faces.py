from __future__ import annotations

import numpy as np
import pytest

from robotcore.description.generation.clearance import gap_between
from robotcore.simulation.painter.faces import Block, split_into_blocks
from tests.drivers.kinematic.rooms import box, post, room


def compute_area(block: Block) -> float:
    x, y = np.array(block.outline).T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def test_separate_prisms_are_not_split() -> None:
    world = room(box(0.0, 0.0, 1.0, 0.2), box(0.0, 0.2, 1.0, 0.2, name="beside"), post(1.0, 1.0, 0.2))
    assert {block.outline for block in split_into_blocks(world)} == {prism.outline for prism in world.prisms}


def test_taller_of_two_overlapping_prisms_keeps_its_outline() -> None:
    low, tall = box(0.0, 0.0, 1.0, 0.2), box(0.0, 0.0, 0.2, 1.0, height=0.5, name="tall")
    blocks = split_into_blocks(room(low, tall))
    assert [block.outline for block in blocks if block.prism_index == 1] == [tall.outline]
    assert sum(compute_area(block) for block in blocks if block.prism_index == 0) == pytest.approx(0.2 - 0.04)


def test_prism_inside_a_taller_prism_has_no_block() -> None:
    blocks = split_into_blocks(room(post(0.0, 0.0, 0.1), box(0.0, 0.0, 1.0, 1.0, height=0.5)))
    assert {block.prism_index for block in blocks} == {1}


def test_blocks_never_overlap() -> None:
    heap = [box(0.1 * i, 0.05 * i, 0.8, 0.15, height=0.2 + 0.1 * (i % 3), yaw=0.7 * i, name=f"b{i}") for i in range(6)]
    blocks = split_into_blocks(room(*heap, post(0.2, 0.1, 0.2)))
    pairs = [(one, other) for i, one in enumerate(blocks) for other in blocks[i + 1 :]]
    assert min(gap_between(one.outline, other.outline) for one, other in pairs) > -1e-8
    assert all(compute_area(block) > 0 for block in blocks)
