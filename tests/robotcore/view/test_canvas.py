from __future__ import annotations

import numpy as np

from robotcore.view.canvas import Canvas, text_width


def test_text_that_opencv_cannot_write_is_drawn_as_its_escape() -> None:
    sheets = []
    for words in ("\ud800", r"\ud800"):
        sheets.append(Canvas(100, 40, (255, 255, 255)))
        assert sheets[-1].text((5, 30), words, (0, 0, 0), 12) == text_width(words, 12) > 0
    assert np.array_equal(sheets[0].image(), sheets[1].image())
