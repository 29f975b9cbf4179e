"""Translate the errors of the board's library into errors with a remedy."""

from collections.abc import Iterator
from contextlib import contextmanager

from robotcore.errors import DeviceError


@contextmanager
def translate_errors(device: str) -> Iterator[None]:
    """Raise DeviceError with the device's name for each error of the board's library.

    The invented board raises only ConnectionError. Name all errors of your library here.
    """
    try:
        yield
    except ConnectionError as error:
        raise DeviceError(
            device, "the board does not answer. Check its cable and its power", kind="board-silent"
        ) from error
