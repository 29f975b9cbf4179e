"""The arguments of `robotcore.open`. In a message, they replace the options of the command line."""

from __future__ import annotations

import re

from robotcore.errors import RobotcoreError
from robotcore.plugins import backend_names

ARGUMENTS = {
    "--backend": "backend",
    "--fault": "faults",
    "--force": "force=True",
    "--foxglove": "foxglove",
    "--gui": "gui=True",
    "--host": 'options={"host": …}',
    "--ideal": "ideal=True",
    "--option file=RUN.mcap": 'options={"file": "RUN.mcap"}',
    "--picture FILE.png": "robot.show()",
    "--port": 'options={"port": …}',
    "--randomise": "randomise=True",
    "--rate": "rate_hz",
    "--robot": "robot",
    "--seed": "seed",
    "--view": "view",
    "--world": "world",
}
"""What to write in Python for each option that the message of an error may name."""

_COMMAND = r"robotcore [a-z]+(?:[^.;\n]|\.(?=\S))*"
"""A command in a message keeps its options, such as ``robotcore doctor --robot FILE.toml``."""


def name_arguments(error: RobotcoreError) -> RobotcoreError:
    """Replace the options in the text of an error by the arguments of `robotcore.open`, and return the error.

    >>> str(name_arguments(RobotcoreError("Choose another --backend, or take --rate 20")))
    'Choose another backend, or take rate_hz=20'
    """
    options = "|".join(map(re.escape, ARGUMENTS))
    values = "|".join([r"\d+(?:\.\d+)?", r"/\S+", *map(re.escape, backend_names())])
    pattern = re.compile(rf"{_COMMAND}|(?P<option>{options})(?![\w-])(?: (?P<value>{values})\b)?")
    error.args = tuple(pattern.sub(_replace, each) if isinstance(each, str) else each for each in error.args)
    return error


def _replace(match: re.Match[str]) -> str:
    option, value = match["option"], match["value"]
    if not option or not value:
        return ARGUMENTS[option] if option else match[0]
    literal = value if value[0].isdigit() else f'"{value}"'
    argument = ARGUMENTS[option]
    return argument.replace("…", literal) if "…" in argument else f"{argument}={literal}"
