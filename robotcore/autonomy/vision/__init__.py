"""Vision: finds blobs of a colour in pictures, and draws boxes around them."""

from robotcore.autonomy.vision.annotate import draw_boxes
from robotcore.autonomy.vision.colour_detector import HUES, Blob, ColourDetector, hue_of

__all__ = ["HUES", "Blob", "ColourDetector", "draw_boxes", "hue_of"]
