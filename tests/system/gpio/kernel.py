"""Debian's kernel with the module gpio-sim, which Debian leaves out. It is built from Debian's source."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.system import needs

TOOLS = ("qemu-system-x86", "busybox-static", "linux-headers-amd64", "kmod", "gcc", "libc6-dev", "make", "xz-utils")
LOADED = ("virtio_pci", "9pnet_virtio", "9p", "overlay", "gpio_sim", "vivid", "i2c_dev", "i2c_stub", "evdev", "uinput")
"""The kernel modules for the host's files, the GPIO chip, the camera, the I2C bus and the gamepad."""

IMAGE_PARTS = (
    "kernel/fs",
    "kernel/net/9p",
    "kernel/drivers/virtio",
    "kernel/drivers/media",
    "kernel/drivers/i2c",
    "kernel/drivers/input/evdev.ko",
    "kernel/drivers/input/misc/uinput.ko",
    "modules.*",
)
SOURCES = ("drivers/gpio/gpio-sim.c", "drivers/gpio/gpiolib.h", "kernel/irq/irq_sim.c")
KBUILD = "obj-m := gpio_sim.o\ngpio_sim-y := gpio-sim.o irq_sim.o\n"
PARAMETER = "static bool persist_gpio_outputs;\nmodule_param(persist_gpio_outputs, bool, 0644);\n"
EDITS = (
    # A module may not call irq_to_desc.
    ("irq_sim.c", "handle_simple_irq(irq_to_desc(irqnum))", "generic_handle_irq(irqnum)"),
    # Lines keep their level after their process has ended, as on Raspberry Pi OS.
    ("gpio-sim.c", "static void gpio_sim_free(", f"{PARAMETER}static void gpio_sim_free("),
    (
        "gpio-sim.c",
        "__assign_bit(offset, chip->value_map, !!test_bit(offset, chip->pull_map));",
        "if (!persist_gpio_outputs)\n\t\t__assign_bit(offset, chip->value_map, !!test_bit(offset, chip->pull_map));",
    ),
)
INIT = Path(__file__).with_name("init.sh")


@dataclass(frozen=True)
class Kernel:
    """The files that the virtual machine boots."""

    image: Path
    initramfs: Path


def kernel() -> Kernel:
    """Return the kernel from the cache; build it if the cache has none. Raises NotRunError if that fails."""
    needs.packages(*TOOLS)
    release = _release()
    recipe = hashlib.sha256(Path(__file__).read_bytes() + INIT.read_bytes()).hexdigest()[:8]
    folder = needs.cache() / f"linux-{release}-{recipe}"
    if not folder.is_dir():
        with TemporaryDirectory(dir=needs.cache()) as scratch:
            _make(Path(scratch), release).replace(folder)
    return Kernel(folder / "vmlinuz", folder / "initramfs")


def _release() -> str:
    releases = [path.name.removeprefix("linux-headers-") for path in Path("/usr/src").glob("linux-headers-6.1.*-amd64")]
    if not releases:
        raise needs.NotRunError("needs the headers of Debian's kernel 6.1, and there are none in /usr/src")
    return max(releases, key=lambda release: [int(number) for number in re.findall(r"\d+", release)])


def _make(scratch: Path, release: str) -> Path:
    """Return a folder with the kernel and its initramfs."""
    needs.download(scratch, f"linux-image-{release}", "linux-source-6.1")
    modules = scratch / "lib" / "modules" / release
    parts = [f"./boot/vmlinuz-{release}", *(f"./lib/modules/{release}/{part}" for part in IMAGE_PARTS)]
    _unpack(next(scratch.glob("linux-image-*.deb")), scratch, parts)
    _build(scratch, release)
    modules.joinpath("updates").mkdir()
    shutil.copy(scratch / "module" / "gpio_sim.ko", modules / "updates")
    _run("depmod", "--basedir", str(scratch), release)
    made = scratch / "made"
    made.mkdir()
    shutil.copy(scratch / "boot" / f"vmlinuz-{release}", made / "vmlinuz")
    made.joinpath("initramfs").write_bytes(_initramfs(scratch, release))
    return made


def _unpack(package: Path, folder: Path, parts: list[str]) -> None:
    """Unpack paths of a Debian package; the paths may have wildcards."""
    with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", package], stdout=subprocess.PIPE) as tar:
        command = ["tar", "--extract", "--wildcards", "--directory", str(folder), *parts]
        subprocess.run(command, stdin=tar.stdout, check=True)


def _build(scratch: Path, release: str) -> None:
    """Build gpio_sim.ko in the folder ``module``, outside the kernel's tree."""
    _unpack(next(scratch.glob("linux-source-*.deb")), scratch, ["./usr/src/linux-source-*.tar.xz"])
    module = scratch / "module"
    module.mkdir()
    archive = next(scratch.glob("usr/src/linux-source-*.tar.xz"))
    wanted = [f"{archive.name.removesuffix('.tar.xz')}/{source}" for source in SOURCES]
    _run("tar", "--extract", "--file", str(archive), "--transform", "s,.*/,,", "--directory", str(module), *wanted)
    for name, old, new in EDITS:
        text = module.joinpath(name).read_text()
        if text.count(old) != 1:
            raise needs.NotRunError(f"needs {name} of Linux {release} to have one {old!r}")
        module.joinpath(name).write_text(text.replace(old, new))
    module.joinpath("Makefile").write_text(KBUILD)
    _run("make", "--directory", f"/lib/modules/{release}/build", f"M={module}", "modules")


def _initramfs(scratch: Path, release: str) -> bytes:
    """Return the initial file system: busybox, the modules in their loading order, and the init script."""
    tree = scratch / "initramfs"
    for name in ("bin", "dev", "modules", "host", "written", "root"):
        tree.joinpath(name).mkdir(parents=True)
    shutil.copy("/bin/busybox", tree / "bin")
    shutil.copy(INIT, tree / "init")
    tree.joinpath("init").chmod(0o755)
    for number, module in enumerate(_sort_modules(scratch, release)):
        shutil.copy(module, tree / "modules" / f"{number:02}-{module.name}")
    names = "\n".join(str(path.relative_to(tree)) for path in sorted(tree.rglob("*")))
    command = ["busybox", "cpio", "-o", "-H", "newc"]
    return subprocess.run(command, cwd=tree, input=names.encode(), capture_output=True, check=True).stdout


def _sort_modules(scratch: Path, release: str) -> list[Path]:
    """Return the files of the modules, each after its dependencies."""
    command = ["modprobe", "--dirname", str(scratch), "--set-version", release, "--show-depends"]
    files: dict[Path, None] = {}
    for name in LOADED:
        lines = subprocess.run([*command, name], capture_output=True, text=True, check=True).stdout.splitlines()
        files.update((Path(line.split()[1]), None) for line in lines if line.startswith("insmod"))
    return list(files)


def _run(*command: str) -> None:
    environment = {**os.environ, "LC_ALL": "C"}
    run = subprocess.run(command, check=False, capture_output=True, text=True, env=environment)
    if run.returncode:
        raise needs.NotRunError(
            f"needs {command[0]} to build a kernel module, which failed: {needs.last_line(run.stderr)}"
        )
