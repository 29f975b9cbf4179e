"""Faults in one field of the samples of any sensor: noise, bias, a stuck value, spikes. The times do not change.

The fields are those that are annotated with a unit. Their values keep their type. In a tuple, each number is changed.
`Sensor.limit_sample` limits the changed values.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import replace
from itertools import repeat
from typing import Annotated, Any, ClassVar, get_args, get_type_hints

from pydantic import Field, ValidationInfo, model_validator

from robotcore.hal.device import Sensor, list_values
from robotcore.hal.kind import load_kind
from robotcore.runtime.faults.base import FaultContext, Probability, SensorFault
from robotcore.runtime.faults.targets import TargetClass
from robotcore.runtime.layers.base import Reader

Number = Annotated[float, Field(ge=-1e6, le=1e6, description="number")]
Size = Annotated[float, Field(gt=0, le=1e6, description="number")]

_CONVERTERS: dict[type, Callable[[float], float]] = {float: float, int: round, bool: bool}
"""For each type of a field, the function that converts a changed value to it."""


class FieldFault(SensorFault):
    """The base class of faults that change one field of a sensor's samples.

    types: the types of the fields that the fault can change. A sensor without such a field cannot have the fault.
    """

    target_classes = (Sensor,)
    types: ClassVar[tuple[type, ...]] = (float, int)

    field: Annotated[str, Field(description="name")] | None = None
    """The name of the field. It can be left out if a sample has one field of these types."""

    @classmethod
    def fits(cls, target: TargetClass) -> bool:
        return super().fits(target) and bool(cls._list_fields(target.kind))

    @classmethod
    def _list_fields(cls, kind: str) -> dict[str, type]:
        """Return the fields in the samples of a kind that the fault can change, and the types of their numbers."""
        sample = load_kind(kind).sample
        hints = get_type_hints(sample)
        types = {each.field: (*get_args(hints[each.field]), hints[each.field])[0] for each in list_values(sample)}
        return {field: type_ for field, type_ in types.items() if type_ in cls.types}

    def _select_field(self, kind: str) -> tuple[str, type]:
        fields = self._list_fields(kind)
        name = next(iter(fields)) if self.field is None and len(fields) == 1 else self.field
        if name in fields:
            return name, fields[name]
        problem = f"this fault cannot change the field {name!r}" if name else "the samples have several fields"
        raise ValueError(f"{problem}. Write {' or '.join(f'field={each}' for each in fields)}")

    @model_validator(mode="after")
    def _require_field(self, info: ValidationInfo) -> FieldFault:
        if info.context:
            self.require_fit(*self._select_field(info.context["target"].kind))
        return self

    def require_fit(self, field: str, kind: type) -> None:
        """Raise ValueError if the parameters do not fit a field of a type."""

    @abstractmethod
    def distort(self, context: FaultContext, sensor: str, value: float, time: float) -> float:
        """Return the changed value of a sample that a sensor captured at ``time``, in seconds.

        sensor: the name of the sensor. For a number in a tuple, its index follows.
        """

    def change(self, context: FaultContext, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        field, kind = self._select_field(sensor.kind)
        convert = _CONVERTERS[kind]

        def change(name: str, value: float, time: float) -> float:
            return convert(self.distort(context, name, value, time))

        def read_distorted() -> Any:
            sample = read()
            if not self.is_active(sample.time):
                return sample
            value = getattr(sample, field)
            if isinstance(value, tuple):
                names = (f"{sensor.name}[{index}]" for index in range(len(value)))
                changed: Any = tuple(map(change, names, value, repeat(sample.time)))
            else:
                changed = change(sensor.name, value, sample.time)
            return sensor.limit_sample(replace(sample, **{field: changed}))

        return read_distorted


class FieldNoise(FieldFault):
    """A number has normal noise with the given standard deviation."""

    example = "encoders noise=0.05"

    value: Size

    def distort(self, context: FaultContext, sensor: str, value: float, time: float) -> float:
        return value + context.noise(sensor, self.value).draw_number(time)


class FieldBias(FieldFault):
    """The given number is added to a number."""

    example = "left_encoder bias=0.5 after=5"

    value: Number

    def distort(self, context: FaultContext, sensor: str, value: float, time: float) -> float:
        return value + self.value


class StuckField(FieldFault):
    """A number always has the given value. A contact is 1 or 0, for pressed or not."""

    types = (float, int, bool)
    example = "right_encoder stuck=0 after=5"

    value: Number

    def require_fit(self, field: str, kind: type) -> None:
        if kind is bool and self.value not in (0, 1):
            raise ValueError(f"{field} cannot be {self.value:g}. Write 0 or 1")

    def distort(self, context: FaultContext, sensor: str, value: float, time: float) -> float:
        return self.value


class FieldSpikes(FieldFault):
    """A number is wrong by ``size``, up or down, with the given probability for each sample. A contact is reversed."""

    types = (float, int, bool)
    example = "encoders spikes=0.1 size=2"

    value: Probability
    size: Size | None = None

    def require_fit(self, field: str, kind: type) -> None:
        if kind is bool and self.size is not None:
            raise ValueError(f"spikes of {field} have no size. Leave size out")
        if kind is not bool and self.size is None:
            raise ValueError(f"spikes of {field} need a size. Add size=NUMBER")

    def distort(self, context: FaultContext, sensor: str, value: float, time: float) -> float:
        random = context.random_at(sensor, time)
        if random.random() >= self.value:
            return value
        if self.size is None:
            return not value
        return value + self.size if random.random() < 0.5 else value - self.size
