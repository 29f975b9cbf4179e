"""Exposure, gain and white balance of a camera on V4L2, in the kernel's meanings.

Source: https://www.kernel.org/doc/html/latest/userspace-api/media/v4l/ext-ctrls-camera.html, and OpenCV's names for
them in modules/videoio/src/cap_v4l.cpp.
"""

from __future__ import annotations

import cv2

from drivers.raspberrypi.cameras.settings import UsbCameraSettings

AUTO, MANUAL, APERTURE_PRIORITY = 0, 1, 3
"""V4L2_CID_EXPOSURE_AUTO; webcams, whose aperture is fixed, call their automatic aperture priority."""

EXPOSURE_UNIT_S = 100e-6
"""V4L2_CID_EXPOSURE_ABSOLUTE counts in it."""


class UsbControls:
    """What can be set on a capture that is open. A webcam keeps it when it is closed, until it is unplugged."""

    def __init__(self, capture: cv2.VideoCapture) -> None:
        self._capture = capture

    def set_by_hand(self, settings: UsbCameraSettings) -> list[str]:
        """Set what is set by hand, leave the rest to the camera; return the settings that it does not take."""
        taken = {}
        if settings.exposure_s is None:
            self._set(cv2.CAP_PROP_AUTO_EXPOSURE, APERTURE_PRIORITY) or self._set(cv2.CAP_PROP_AUTO_EXPOSURE, AUTO)
        else:
            taken["exposure_s"] = self._expose(max(1, round(settings.exposure_s / EXPOSURE_UNIT_S)))
        if settings.white_balance_k is None:
            self._set(cv2.CAP_PROP_AUTO_WB, 1)
        else:
            taken["white_balance_k"] = self._balance(settings.white_balance_k)
        if settings.gain is not None:
            taken["gain"] = self._set(cv2.CAP_PROP_GAIN, settings.gain)
        return [name for name, is_taken in taken.items() if not is_taken]

    def hold(self) -> list[str]:
        """Keep exposure and white balance as they are now; return which of them the camera does not let be held."""
        exposure = self._capture.get(cv2.CAP_PROP_EXPOSURE)
        kelvin = self._capture.get(cv2.CAP_PROP_WB_TEMPERATURE)
        held = {
            "exposure": exposure > 0 and self._expose(exposure),
            "white balance": kelvin > 0 and self._balance(kelvin),
        }
        return [what for what, is_held in held.items() if not is_held]

    def _expose(self, units: float) -> bool:
        return self._set(cv2.CAP_PROP_AUTO_EXPOSURE, MANUAL) and self._set(cv2.CAP_PROP_EXPOSURE, units)

    def _balance(self, kelvin: float) -> bool:
        return self._set(cv2.CAP_PROP_AUTO_WB, 0) and self._set(cv2.CAP_PROP_WB_TEMPERATURE, kelvin)

    def _set(self, control: int, value: float) -> bool:
        return self._capture.set(control, value)
