"""Builds the firmware and writes it to a board, with arduino-cli or with avr-gcc and avrdude."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from robotcore.errors import FirmwareError
from robotcore.hardware.firmware.board import BoardType

AVRDUDE = "avrdude"
FLASH_REMEDY = "The board may be of another type or have another bootloader. Try --board nano-old, nano and uno"

ARDUINO_CLI = "arduino-cli"
"""The program arduino-cli, version 0.13 or later.

Source of its commands: https://arduino.github.io/arduino-cli/latest/commands/.
"""

ARDUINO_CLI_URL = "https://arduino.github.io/arduino-cli"
ARDUINO_CORE = "arduino:avr"

AVR_GCC = "avr-gcc"
AVR_CORE = Path("/usr/share/arduino/hardware/arduino/avr")
"""The Arduino core of Debian's package arduino-core-avr.

The compiler commands of this module are those of the core's platform.txt without link-time optimisation.
"""

DEBIAN_PACKAGES = "gcc-avr arduino-core-avr"

_COMMON = ("-c", "-g", "-Os", "-mmcu=atmega328p", "-ffunction-sections", "-fdata-sections")
_CPP = ("-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics")
_DEFINED = ("F_CPU=16000000L", "ARDUINO=10819", "ARDUINO_ARCH_AVR", "DECIMAL_DIG=10")
"""Preprocessor macros of the build. DECIMAL_DIG is needed because avr-gcc before version 7 does not define it."""


@dataclass(frozen=True)
class FirmwareImage:
    """The result of a build."""

    image: Path
    """The file of the program, in Intel's hexadecimal format."""
    tool: str
    """The name of the tool that built the program."""
    size_bytes: int
    """The number of bytes that the program occupies in the board's flash memory."""


def build(sketch: Path, board: BoardType, folder: Path) -> FirmwareImage:
    """Build a sketch with arduino-cli, or else with avr-gcc and Debian's Arduino core, and return the result.

    sketch: the folder of the sketch.
    folder: the folder for the files of the build.

    Raises FirmwareError if no compiler is installed, or if the sketch does not compile or is too large for the board.
    """
    if has_arduino_cli() and has_arduino_core():
        tool, image = ARDUINO_CLI, build_with_arduino_cli(sketch, board, folder)
    elif has_avr_gcc():
        tool, image = AVR_GCC, build_with_avr_gcc(sketch, board, folder)
    else:
        raise FirmwareError(
            f"no compiler for the board {board.name} is installed. {_install_hint()}",
            kind="no-build-tool",
            board=board.name,
        )
    return FirmwareImage(image, tool, _measure_size(image, board))


def _install_hint() -> str:
    core = "arduino-cli core install arduino:avr"
    if has_arduino_cli():
        return f"Install the board's core: {core}"
    debian = f"on Debian or Raspberry Pi OS: sudo apt install {DEBIAN_PACKAGES}"
    return f"Install arduino-cli ({ARDUINO_CLI_URL}) and its core: {core}; or {debian}"


def _measure_size(image: Path, board: BoardType) -> int:
    size = sum(int(line[1:3], 16) for line in image.read_text().splitlines() if line[7:9] == "00")
    if size > board.flash_bytes:
        raise FirmwareError(
            f"{image}: it has {size} bytes, but the board {board.name} has room for {board.flash_bytes}. Make the "
            "sketch smaller",
            kind="image-too-large",
            size_bytes=size,
            flash_bytes=board.flash_bytes,
        )
    return size


def flash(image: Path, board: BoardType, port: str) -> str:
    """Write an image to the board at a port, and verify it. Return the name of the tool: avrdude or arduino-cli.

    Raises FirmwareError if the tool fails, or if none is installed.
    """
    if is_installed(AVRDUDE):
        run_tool(_avrdude_command(image, board, port), f"flashing the {board.name} at {port}", FLASH_REMEDY)
        return AVRDUDE
    if has_arduino_cli():
        flash_with_arduino_cli(image, board, port)
        return ARDUINO_CLI
    raise FirmwareError(
        f"no tool that can flash the board {board.name} is installed. On Debian or Raspberry Pi OS: sudo apt install "
        f"{AVRDUDE}",
        kind="no-flash-tool",
        board=board.name,
    )


def _avrdude_command(image: Path, board: BoardType, port: str) -> list[str]:
    # Sources: avrdude(1), and the upload pattern in the Arduino core's platform.txt.
    chip = ["-p", "m328p", "-c", "arduino", "-P", port, "-b", str(board.upload_baud)]
    return [AVRDUDE, "-q", *chip, "-D", "-U", f"flash:w:{image}:i"]


def has_arduino_cli() -> bool:
    """Return whether arduino-cli is installed."""
    return is_installed(ARDUINO_CLI)


def has_arduino_core() -> bool:
    """Return whether arduino-cli has the core of these boards. Raises FirmwareError if arduino-cli fails."""
    listed = run_tool([ARDUINO_CLI, "core", "list"], "listing the installed cores")
    return any(line.split()[:1] == [ARDUINO_CORE] for line in listed.splitlines())


def build_with_arduino_cli(sketch: Path, board: BoardType, folder: Path) -> Path:
    """Build a sketch into a folder with arduino-cli, and return the image.

    Raises FirmwareError with the compiler's output if the sketch does not compile.
    """
    folder.mkdir(parents=True, exist_ok=True)
    run_tool([ARDUINO_CLI, "compile", "--fqbn", board.fqbn, "--output-dir", folder, sketch], f"building {sketch.name}")
    return folder / f"{sketch.name}.ino.hex"


def flash_with_arduino_cli(image: Path, board: BoardType, port: str) -> None:
    """Write an image to the board at a port with arduino-cli. Raises FirmwareError with its output if it fails."""
    where = ["--fqbn", board.fqbn, "--port", port, "--verify"]
    run_tool([ARDUINO_CLI, "upload", *where, "--input-file", image], f"flashing the {board.name} at {port}")


def has_avr_gcc() -> bool:
    """Return whether avr-gcc and Debian's Arduino core are installed."""
    return (
        is_installed("avr-gcc", "avr-g++", "avr-objcopy") and (AVR_CORE / "cores" / "arduino" / "Arduino.h").is_file()
    )


def build_with_avr_gcc(sketch: Path, board: BoardType, folder: Path, *, flags: Sequence[str] = ()) -> Path:
    """Build a sketch into a folder with avr-gcc, and return the image.

    Unlike arduino-cli, this adds no function prototypes. So the sketch must declare each function before its use.

    flags: additional compiler flags for the sketch, not for the core.

    Raises FirmwareError with the compiler's output if the sketch does not compile.
    """
    folder.mkdir(parents=True, exist_ok=True)
    joined = _join_sources(sketch, folder)
    core = AVR_CORE / "cores" / "arduino"
    sketch_files = [joined, *sorted(sketch.glob("*.cpp"))]
    core_files = [path for path in sorted(core.iterdir()) if path.suffix in {".c", ".cpp", ".S"}]
    with ThreadPoolExecutor() as pool:
        compile_file = partial(_compile, board, sketch, folder)
        objects = [
            *pool.map(partial(compile_file, flags), sketch_files),
            *pool.map(partial(compile_file, ["-w"]), core_files),
        ]
    return _link(objects, folder / sketch.name)


def _join_sources(sketch: Path, folder: Path) -> Path:
    # Like arduino-cli: first the .ino file with the sketch's name, then the others.
    first = sketch / f"{sketch.name}.ino"
    others = sorted(path for path in sketch.glob("*.ino") if path != first)
    joined = folder / f"{sketch.name}.ino.cpp"
    joined.write_text("#include <Arduino.h>\n" + "".join(map(_with_line_marker, (first, *others))))
    return joined


def _with_line_marker(source: Path) -> str:
    # Errors of the compiler then name the original file.
    return f'#line 1 "{source}"\n{source.read_text()}\n'


def _compile(board: BoardType, sketch: Path, folder: Path, flags: Sequence[str], source: Path) -> Path:
    target = folder / f"{source.name}.o"
    compiler = "avr-g++" if source.suffix == ".cpp" else "avr-gcc"
    command = [compiler, *_compiler_flags(source, board), *flags, f"-I{sketch}", str(source), "-o", str(target)]
    run_tool(command, f"compiling {source.name}")
    return target


def _compiler_flags(source: Path, board: BoardType) -> Iterator[str]:
    yield from _COMMON
    yield from _CPP if source.suffix == ".cpp" else ()
    yield from ("-x", "assembler-with-cpp") if source.suffix == ".S" else ()
    yield from (f"-D{macro}" for macro in (*_DEFINED, board.macro))
    yield from (f"-I{AVR_CORE / 'cores' / 'arduino'}", f"-I{AVR_CORE / 'variants' / board.variant}")


def _link(objects: list[Path], target: Path) -> Path:
    elf, image = target.with_suffix(".elf"), target.with_suffix(".hex")
    run_tool(
        ["avr-gcc", "-mmcu=atmega328p", "-Os", "-Wl,--gc-sections", *objects, "-lm", "-o", elf], f"linking {elf.name}"
    )
    run_tool(["avr-objcopy", "-O", "ihex", "-R", ".eeprom", elf, image], f"writing {image.name}")
    return image


def is_installed(*names: str) -> bool:
    """Return whether all named programs are on the PATH."""
    return all(map(shutil.which, names))


def run_tool(command: Sequence[str | Path], doing: str, remedy: str = "", timeout: float = 300.0) -> str:
    """Run a tool until it ends, and return its output on stdout and stderr.

    doing: the task of the tool, for error messages, such as ``building robotcore_bridge``.
    remedy: a sentence for the error message if the tool fails.
    timeout: the time limit in seconds.

    Raises FirmwareError if the tool fails, does not end in time, or cannot be run.
    """
    tool = Path(command[0]).name
    try:
        ran = subprocess.run(  # noqa: S603  a known tool, without a shell
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            stdin=subprocess.DEVNULL,
            timeout=timeout,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise FirmwareError(
            f"{doing}: {tool} did not end within {timeout:g} s and was killed",
            kind="tool-timeout",
            tool=tool,
            timeout_s=timeout,
        ) from error
    except OSError as error:
        raise FirmwareError(
            f"{doing}: {tool} cannot be run: {error.strerror}", kind="tool-missing", tool=tool
        ) from error
    if ran.returncode:
        output = ran.stdout.strip() or "nothing"
        advice = f". {remedy}" if remedy else ""
        raise FirmwareError(
            f"{doing}: {tool} failed (exit {ran.returncode}){advice}. Its output:\n{output}",
            kind="tool-failed",
            tool=tool,
            status=ran.returncode,
        )
    return ran.stdout
