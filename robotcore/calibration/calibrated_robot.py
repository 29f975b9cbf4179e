"""Writes the file of a robot that measures: few devices, and motors whose commands are plain duties."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from robotcore.description import RobotDescription, is_own, load_robot, read_shipped
from robotcore.description.file_reading import read_limited
from robotcore.description.loading import MAX_FILE_BYTES, read_toml
from robotcore.errors import UsageError
from robotcore.hal.backend import Backend, Capability
from robotcore.hardware import HardwareBackend
from robotcore.hardware.motor_model import MotorModel
from robotcore.kinds.motor import MotorDescription

FULL_RAD_S = 10.0
"""The velocity for the duty 1 in the file of a robot that measures duties, in rad/s."""

FOLLOW_S = 3600.0
"""The time limit of the check that wheels follow their commands. It is so long that the check has no effect."""

LEASE_TICKS = 10.0
"""The lease of a command in ticks. At the rate of an excitation, a shorter one would end by a delay of the computer."""

COMPENSATED = ("dead_band_rad_s", "forward_gain", "backward_gain")
"""The keys of a motor's description that a run compensates in each command."""

EXCITATION_KINDS = frozenset({"motor", "encoder", "imu"})


@dataclass(frozen=True)
class CalibratedRobot:
    """The robot of a calibration: its description, its backend and the models of its motors."""

    robot: str
    """The name or the file of the robot."""
    description: RobotDescription
    backend: Backend
    options: Mapping[str, Any]
    """The options of the backend for a run."""
    section: str | None
    """The section of the file with the settings of the motors; None for a simulator without one."""
    models: Mapping[str, MotorModel]
    """The models of the drive's motors that take duties, by name."""
    trims: Mapping[str, float]
    """The trims of the drive's motors that take velocities, by name; those that have the setting."""

    @classmethod
    def load(cls, robot: str, backend: Backend, options: Mapping[str, Any]) -> CalibratedRobot:
        """Load a robot, and check its drive and the backend's section of its file.

        Raises UsageError for a robot without a drive, and DescriptionError for mistakes in the file.
        """
        description = backend.load_robot(robot, options)
        if (drive := description.drive) is None:
            text = f"{description.source} has no [drive], so there is nothing to calibrate. Name another --robot"
            raise UsageError(text, kind="no-drive", robot=robot)
        backend.check(description)
        if not isinstance(backend, HardwareBackend):
            return cls(robot, description, backend, options, None, {}, {})
        drivers = {each.name: each.driver for each in backend.bind(description, drive.motors)}
        found = {name: getattr(driver, "model", None) for name, driver in drivers.items()}
        models = {name: model for name, model in found.items() if isinstance(model, MotorModel)}
        if models and len(models) < len(drive.motors):
            lacking = min(set(drive.motors) - models.keys())
            text = f"{description.source}: {lacking} has no model, but other motors of the drive have one"
            raise UsageError(f"{text}. Give all of them one, or none", kind="models-differ", device=lacking)
        trims = {name: driver.trim for name, driver in drivers.items() if hasattr(driver, "trim")}
        if Capability.POSE in backend.capabilities:  # its simulated hardware is that of the robot's own file
            options = {"truth": robot, **options}
        return cls(robot, description, backend, options, backend.section, models, trims)

    @property
    def is_simulated(self) -> bool:
        """Whether the backend is a simulator that has the true pose of the robot."""
        return Capability.POSE in self.backend.capabilities

    @property
    def full_rad_s(self) -> float:
        """The velocity that an excitation commands for the full command, in rad/s."""
        return FULL_RAD_S if self.models else self.max_velocity_rad_s

    @property
    def max_velocity_rad_s(self) -> float:
        """The greatest velocity that all wheels can have, in rad/s."""
        assert self.description.drive
        names = self.description.drive.motors
        motors = (each for each in self.description.all_of(MotorDescription) if each.name in names)
        return min(each.max_velocity_rad_s for each in motors)

    @property
    def max_command(self) -> float:
        """The greatest share of the full command that all motors of the drive take."""
        return min((model.max_duty for model in self.models.values()), default=1.0)

    @contextmanager
    def open_file(self, *, takes_duties: bool, kinds: Collection[str] = EXCITATION_KINDS) -> Iterator[str]:
        """Yield the path of a temporary file of the robot, with which an excitation runs.

        It has only devices of the given kinds. With ``takes_duties``, no rule changes a command.

        takes_duties: whether the velocity `FULL_RAD_S` is the duty 1 of a motor with a model, without a dead band and
            without velocity control. Otherwise the motors and the limits stay as they are.
        kinds: the kinds of the devices that the robot keeps. Servos that steer or carry them stay too.
        """
        import tomlkit

        table = self._build_table(kinds)
        if takes_duties:
            self._linearise(table)
        with TemporaryDirectory(prefix="robotcore-") as folder:
            file = Path(folder, f"{self.description.name}.toml")
            file.write_text(tomlkit.dumps(table), encoding="utf-8")
            load_robot(str(file))
            yield str(file)

    def _build_table(self, kinds: Collection[str]) -> dict[str, Any]:
        content = read_limited(Path(self.robot), MAX_FILE_BYTES) if is_own(self.robot) else None
        table = read_toml(self.description.source, content or read_shipped(self.robot).encode())
        assert self.description.drive
        kept = {each.name for each in self.description.devices if each.kind in kinds}
        kept |= {carrier for name in kept for carrier in self.description.list_carriers(name)}
        kept |= {*filter(None, [self.description.drive.steering_servo])}
        table["devices"] = [each for each in table["devices"] if each["name"] in kept]
        used = {self.backend.name, self.section}
        for section in self.description.backends:
            own = table.pop(section)
            if section in used:
                table[section] = {name: each for name, each in own.items() if name in kept}
        return table

    def _linearise(self, table: dict[str, Any]) -> None:
        table["drive"].pop("max_acceleration_rad_s2", None)
        table["safety"] = {**table.get("safety", {}), "follow_s": FOLLOW_S, "lease_ticks": LEASE_TICKS}
        devices = {each["name"]: each for each in table["devices"]}
        for name, model in self.models.items():
            full = {"dead_band": 0.0, "forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S}
            assert self.section, "models are those of a section"
            settings = table[self.section][name]
            settings["model"] = {**full, "max_duty": model.max_duty}
            settings.pop("control", None)
            devices[name]["max_velocity_rad_s"] = FULL_RAD_S * model.max_duty
            for key in COMPENSATED:  # a run would change the duties
                devices[name].pop(key, None)
