"""What the board's library raises, as errors that say what to do."""

from collections.abc import Iterator
from contextlib import contextmanager

from robotcore.errors import DeviceError


@contextmanager
def in_words(device: str) -> Iterator[None]:
    """Raise DeviceError, by the device's name, for what the library raises.

    ConnectionError stands for the library's own errors: name them here, all of them.
    """
    try:
        yield
    except ConnectionError as error:
        raise DeviceError(device, "the board does not answer. Look at its cable and its power") from error
