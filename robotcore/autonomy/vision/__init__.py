"""Vision: finds blobs of a colour in pictures, and draws boxes around them."""

from robotcore.autonomy.vision.colour_detector import (
    DEFAULT_TOLERANCE,
    HUE_RANGES,
    HUES,
    Blob,
    ColourDetector,
    draw_boxes,
    parse_hue,
)

__all__ = ["DEFAULT_TOLERANCE", "HUES", "HUE_RANGES", "Blob", "ColourDetector", "draw_boxes", "parse_hue"]
