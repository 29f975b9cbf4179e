"""``robotcore faults``: what can be made to fail, on what, and how it is written."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from robotcore.cli.output import as_json, write_json, write_lines, write_table

if TYPE_CHECKING:
    from robotcore.runtime.faults.spec import Parameter


_COMMON = """\
Every fault takes after=SECONDS, from when, and lasts=SECONDS, for how long, on the robot's clock.
Beside every=SECONDS, lasts is for how long it may come again."""


@click.command("faults")
@as_json
def command(*, as_json: bool) -> None:
    """List the faults that --fault knows, and what each is on."""
    from robotcore.plugins import fault_names

    faults = [_fault_row(name) for name in fault_names()]
    if as_json:
        write_json(faults)
    else:
        write_table(("fault", "on", "parameters", "example", "what it does"), map(_row, faults))
        write_lines(f"\n{_COMMON}")


def _fault_row(name: str) -> dict[str, Any]:
    from robotcore.errors import BackendMissingError
    from robotcore.runtime.faults.planning import ROLES, effect_of, load_fault
    from robotcore.runtime.faults.spec import parameters_of

    effect = effect_of(name)
    try:
        fault = load_fault(name)
    except BackendMissingError as error:
        return {"name": effect, "on": [], "parameters": [], "example": "", "summary": str(error)}
    return {
        "name": effect,
        "on": [role for kind, role in ROLES.items() if kind in fault.on],
        "parameters": [_parameter(each) for each in parameters_of(effect, fault)],
        "example": fault.example,
        "summary": (fault.__doc__ or "").strip().partition("\n")[0],
    }


def _parameter(parameter: Parameter) -> dict[str, Any]:
    return {
        "name": parameter.name,
        "unit": parameter.unit,
        "limits": parameter.limits,
        "required": parameter.is_required,
    }


def _row(fault: dict[str, Any]) -> tuple[str, ...]:
    own = (each for each in fault["parameters"] if each["name"] not in ("after", "lasts"))
    parameters = "\n".join(f"{each['name']}: {each['unit']}, {each['limits']}" for each in own)
    return fault["name"], ", ".join(fault["on"]), parameters, fault["example"], fault["summary"]
