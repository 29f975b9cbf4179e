"""What a picture shows: blobs of a colour, and marks on what was found."""

from robotcore.autonomy.vision.blob import Blob
from robotcore.autonomy.vision.colour import ColourDetector
from robotcore.autonomy.vision.hues import HUES, hue_of
from robotcore.autonomy.vision.marks import marked

__all__ = ["HUES", "Blob", "ColourDetector", "hue_of", "marked"]
