"""Build the Containerfile with buildah, and run apps in the container.

python -m tests.system.container

The base image is a Debian that debootstrap makes, under the name of the real one. No image is downloaded.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.system import needs, wheels
from tests.system.speed import scaled

SUITE = "bookworm"
BASE = "debian:bookworm-slim"
"""The name of the base image in the Containerfile."""
IMAGE = "robotcore"
LIMIT_S = 600.0
"""The time limit of a command on the reference machine."""
MAX_SIZE_MB = 700
"""The greatest size of what the container adds to its base, in MB."""
CERTIFICATES = "/etc/robotcore-test-certificates.crt"

PROJECT = "search.py --robot my_robot.toml --world room.toml"


class Buildah:
    """Buildah with a store of its own, without namespaces, so that it also works inside of a container."""

    def __init__(self, folder: Path) -> None:
        self._options = ("--root", str(folder / "store"), "--runroot", str(folder / "run"), "--storage-driver", "vfs")
        self._environment = {**os.environ, "BUILDAH_ISOLATION": "chroot"}

    def __call__(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            ["buildah", *self._options, *arguments],
            env=self._environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=scaled(LIMIT_S),
        )

    def require(self, *arguments: str) -> str:
        """Run a command and return its output; raises NotRunError if it fails."""
        run = self(*arguments)
        if run.returncode:
            raise needs.NotRunError(f"buildah {arguments[0]} failed: {needs.last_line(run.stderr)}")
        return run.stdout.strip()


def main() -> bool:
    """Return whether the container was built and every check passed."""
    needs.debian()
    needs.packages("buildah", "debootstrap")
    with TemporaryDirectory(prefix="robotcore-container-") as scratch:
        folder = Path(scratch)
        buildah = Buildah(folder)
        base = _import_base(buildah)
        built = buildah("bud", *_list_build_options(folder), "--tag", IMAGE, str(_copy_context(folder / "context")))
        if built.returncode:
            print(f"not ok  the container is built\n          {needs.last_line(built.stderr)}", flush=True)
            return False
        print("ok      the container is built", flush=True)
        with _start(buildah) as container:
            problems = [_report(*found) for found in _list_checks(buildah, container, base, folder)]
            return all(problems)


def _report(name: str, problem: str) -> bool:
    print(f"not ok  {name}\n          {problem}" if problem else f"ok      {name}", flush=True)
    return not problem


def _import_base(buildah: Buildah) -> int:
    """Import the Debian as the base image, and return its size in MB."""
    root = needs.cache() / f"container-{SUITE}"
    if not root.is_dir():
        with TemporaryDirectory(dir=needs.cache()) as scratch:
            made = Path(scratch, "root")
            run = subprocess.run(
                ["debootstrap", "--variant=minbase", SUITE, made], capture_output=True, text=True, check=False
            )
            if run.returncode:
                raise needs.NotRunError(f"needs Debian's packages: {needs.last_line(run.stdout)}")
            shutil.rmtree(made / "var" / "cache" / "apt" / "archives")
            made.replace(root)
    name = buildah.require("from", "scratch")
    buildah.require("copy", name, str(root), "/")
    buildah.require("commit", name, BASE)
    return _measure_mb(root)


def _copy_context(folder: Path) -> Path:
    """Build the wheel, and copy it with the files that a build of the container reads."""
    folder.mkdir()
    for name in ("Containerfile", ".dockerignore"):
        shutil.copy(needs.ROOT / name, folder)
    wheels.build(folder / "dist")
    return folder


def _list_build_options(folder: Path) -> list[str]:
    """Return the options for a build from the present base. pip gets this machine's certificates, if it has its own."""
    options = ["--pull-never"]
    if certificates := os.environ.get("PIP_CERT"):
        settings = folder / "pip.conf"
        settings.write_text(f"[global]\ncert = {CERTIFICATES}\n")
        options += ["--volume", f"{certificates}:{CERTIFICATES}:ro", "--volume", f"{settings}:/etc/pip.conf:ro"]
    return options


@contextmanager
def _start(buildah: Buildah) -> Iterator[str]:
    container = buildah.require("from", "--pull-never", f"localhost/{IMAGE}:latest")
    try:
        yield container
    finally:
        buildah("umount", container)
        buildah("rm", container)


def _list_checks(buildah: Buildah, container: str, base: int, folder: Path) -> Iterator[tuple[str, str]]:
    """Yield the name and the problem of each check."""
    work = folder / "work"
    work.mkdir()
    work.chmod(0o777)

    def run(command: str, *, inside: str = "/project") -> subprocess.CompletedProcess[str]:
        options = ("--volume", f"{work}:/project", "--workingdir", inside)
        return buildah("run", *options, container, "--", *command.split())

    config = json.loads(buildah.require("inspect", "--type", "image", f"localhost/{IMAGE}:latest"))["OCIv1"]["config"]
    yield "its entry point is robotcore", "" if config["Entrypoint"] == ["robotcore"] else str(config)
    yield "its user is not root", "" if (user := run("id -un").stdout.strip()) == "robot" else user
    yield "the demo runs on PyBullet", _expect(run("robotcore demo"), "success  green-search on pybullet")
    yield "new makes a project", _expect(run("robotcore new my-robot"), "has been created")
    project = "/project/my-robot"
    yield "its tests pass", _expect(run("python -m pytest -q -p no:cacheprovider", inside=project), "6 passed")
    swept = run(f"robotcore sweep {PROJECT} --seeds 1-3 --backend mujoco --require verified>=1", inside=project)
    yield "a sweep runs on MuJoCo, with a bound", _expect(swept, "3/3")
    recorded = run(f"robotcore run {PROJECT} --seed 7 --record run.mcap", inside=project)
    yield "a run is recorded", _expect(recorded, "The recording: run.mcap")
    added = _measure_mb(Path(buildah.require("mount", container))) - base
    problem = "" if added <= MAX_SIZE_MB else f"it adds {added} MB"
    yield f"it adds {added} MB to Debian's {base} MB, at most {MAX_SIZE_MB}", problem


def _measure_mb(folder: Path) -> int:
    run = subprocess.run(["du", "--summarize", "--block-size=MB", folder], capture_output=True, text=True, check=True)
    return int(run.stdout.split("MB")[0])


def _expect(run: subprocess.CompletedProcess[str], text: str) -> str:
    if run.returncode == 0 and text in run.stdout:
        return ""
    return f"exit status {run.returncode}: {needs.last_line(run.stderr or run.stdout)}"


if __name__ == "__main__":
    needs.leave_on_sigterm()
    sys.exit(needs.run_or_skip("container", main))
