"""What a picture shows: blobs of a colour, and marks on what was found."""

from robotcore.vision.blob import Blob
from robotcore.vision.colour import ColourDetector
from robotcore.vision.hues import HUES, hue_of
from robotcore.vision.marks import marked

__all__ = ["HUES", "Blob", "ColourDetector", "hue_of", "marked"]
