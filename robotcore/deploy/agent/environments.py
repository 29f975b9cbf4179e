"""Virtual environments on the robot. Releases with the same requirements share one environment."""

from __future__ import annotations

import errno
import json
import os
import platform
import re
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from hashlib import sha256
from importlib import metadata
from pathlib import Path

from robotcore.deploy.agent import files
from robotcore.deploy.agent.errors import MAKE_ROOM, AgentError, KnownFailure, explain_known
from robotcore.deploy.agent.files import Layout, measure_free_space
from robotcore.deploy.agent.releases import ENVIRONMENT
from robotcore.deploy.agent.rpc import report_progress
from robotcore.deploy.agent.uploads import delete, discard

COMPLETE_FILE = "whole.json"
"""The file that lists an environment's contents. An environment without this file is incomplete."""

_EMPTY_BYTES = 30_000_000
"""The size of an environment that has only pip, in bytes."""

_PROGRESS = re.compile(r"\s*(?:Collecting|Downloading|Using cached|Processing|Building|Installing|Successfully) ")
_SYSTEM_PACKAGE = re.compile(r"Requirement already satisfied: ([\w.-]+).*? in (/.*?)(?: \(|$)")
_SECRET = re.compile(r"(?<=://)[^/\s@]+@")
_KEPT_LINES = 400


@dataclass(frozen=True)
class EnvironmentSpec:
    """The specification of an environment's contents: its requirements and its Python."""

    requirements: tuple[str, ...]
    """The requirements in pip's format, sorted."""
    python: str
    """The version of Python and the processor, such as ``cpython-311 aarch64``."""

    @classmethod
    def from_requirements(cls, requirements: Iterable[str]) -> EnvironmentSpec:
        """Return the specification of an environment with these requirements for the running Python."""
        lines = sorted({" ".join(requirement.split()) for requirement in requirements})
        return cls(tuple(lines), f"{sys.implementation.cache_tag} {platform.machine()}")

    @property
    def digest(self) -> str:
        """A short hash of the specification. The name of the environment's folder begins with it."""
        return sha256(json.dumps(asdict(self)).encode()).hexdigest()[:12]


@dataclass(frozen=True)
class PipInputs:
    """The inputs of pip in addition to the requirements."""

    wheels: Path | None = None
    """The folder of uploaded wheels; None if pip uses the network."""
    site: Path | None = None
    """The folder of the packages in the release. pip does not install these packages."""
    handles: tuple[int, ...] = ()
    """The file handles that pip inherits, such as the handle of the lock."""


def find_environment(layout: Layout, spec: EnvironmentSpec) -> Path | None:
    """Return the folder of an existing environment with this specification; None if there is no such environment.

    An environment also uses packages of the operating system, such as picamera2 from apt. After an update of such a
    package, the environment no longer fits.
    """
    made = sorted(layout.environments.glob(f"{spec.digest}-*"), reverse=True)
    return next((folder for folder in made if _is_unchanged(folder, spec)), None)


def create_environment(layout: Layout, spec: EnvironmentSpec, release: str, inputs: PipInputs) -> Path:
    """Create an environment for a release, and return its folder. The caller must hold the lock.

    The function first deletes incomplete environments of killed processes. It always creates a new folder, because an
    older environment with the same requirements may be in use.

    Raises AgentError if pip or venv fails.
    """
    folder = layout.environments / f"{spec.digest}-{release}"
    layout.environments.mkdir(parents=True, exist_ok=True)
    for incomplete in [path for path in layout.environments.iterdir() if not path.joinpath(COMPLETE_FILE).exists()]:
        delete(incomplete)
    try:
        _create_venv(folder, with_pip=bool(spec.requirements))
        system_packages = install_requirements(folder, spec.requirements, inputs) if spec.requirements else ()
        os.sync()
        system_versions = {name: _read_system_version(name) for name in sorted(system_packages)}
        contents = {**asdict(spec), "leans_on": system_versions}
        files.write_file(folder / COMPLETE_FILE, json.dumps(contents, indent=2) + "\n")
    except BaseException:
        delete(folder)
        raise
    return folder


def discard_unused(layout: Layout) -> None:
    """Delete the environments that no release or upload uses. The caller must hold the lock."""
    folders = [*layout.releases.glob("*"), *layout.incoming.glob("*")]
    used = {link.readlink().name for folder in folders if (link := folder / ENVIRONMENT).is_symlink()}
    for folder in [path for path in layout.environments.glob("*") if path.name not in used]:
        discard(layout, folder)


def _create_venv(folder: Path, *, with_pip: bool) -> None:
    command = [sys.executable, "-I", "-m", "venv", "--system-site-packages", *([] if with_pip else ["--without-pip"])]
    made = subprocess.run([*command, folder], capture_output=True, text=True, check=False)  # noqa: S603  our own Python
    if made.returncode == 0:
        return
    output = made.stdout + made.stderr
    if "ensurepip is not" in output:
        raise AgentError("python3-venv is missing on the robot", "On the robot: sudo apt install python3-venv", "venv")
    if measure_free_space(folder) < _EMPTY_BYTES:  # venv hides the output of the pip that failed
        output = os.strerror(errno.ENOSPC)
    raise explain_failure(output.splitlines(), is_offline=False)


def _is_unchanged(folder: Path, spec: EnvironmentSpec) -> bool:
    try:
        contents = json.loads(folder.joinpath(COMPLETE_FILE).read_text(encoding="utf-8"))
        existing = EnvironmentSpec(tuple(contents["requirements"]), contents["python"])
        system_versions = dict(contents["leans_on"])
    except (OSError, ValueError, TypeError, KeyError):
        return False
    is_unchanged = all(_read_system_version(name) == version for name, version in system_versions.items())
    return existing == spec and is_unchanged and folder.joinpath("bin", "python").exists()


def _read_system_version(distribution: str) -> str | None:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None


def install_requirements(environment: Path, requirements: Sequence[str], inputs: PipInputs) -> set[str]:
    """Install requirements, and return the names of packages that the operating system already has.

    Raises AgentError if pip fails. If the report of the progress raises, pip is killed with all its children.
    """
    lines: deque[str] = deque(maxlen=_KEPT_LINES)
    system_packages: set[str] = set()
    with _start_pip(environment, requirements, inputs) as running:
        assert running.stdout
        try:
            for text in running.stdout:
                line = _SECRET.sub("****@", text.rstrip("\n"))
                lines.append(line)
                if _PROGRESS.match(line):
                    report_progress(line.strip())
                elif (had := _SYSTEM_PACKAGE.match(line)) and not _is_below(Path(had[2]), environment, inputs.site):
                    system_packages.add(had[1])
        except BaseException:
            with suppress(ProcessLookupError):
                os.killpg(running.pid, signal.SIGKILL)
            raise
    if running.returncode:
        raise explain_failure(lines, is_offline=inputs.wheels is not None)
    return system_packages


def _start_pip(environment: Path, requirements: Sequence[str], inputs: PipInputs) -> subprocess.Popen[str]:
    variables = {"LC_ALL": "C.UTF-8", "PYTHONNOUSERSITE": "1", "PYTHONPATH": str(inputs.site or "")}
    options = ["--no-input", "--disable-pip-version-check", "--progress-bar=off", "--prefer-binary", "--retries=2"]
    source = ["--no-index", f"--find-links={inputs.wheels}"] if inputs.wheels else []
    return subprocess.Popen(  # noqa: S603  no shell
        [str(environment / "bin/python"), "-m", "pip", "install", *options, *source, "--", *requirements],
        cwd=environment,
        env={**os.environ, **variables},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        pass_fds=inputs.handles,
        start_new_session=True,
    )


def _is_below(place: Path, *folders: Path | None) -> bool:
    return any(folder and place.is_relative_to(folder) for folder in folders)


_CORRECT_IT = "Correct it in the project's dependencies"


_COMMON = (
    KnownFailure(r"No space left on device|Disk quota exceeded", "disk", "the robot's disk is full", MAKE_ROOM),
    KnownFailure(
        r"ResolutionImpossible",
        "requirement",
        "the requirements contradict each other",
        "Relax the project's requirements. pip install on your computer names those in conflict",
    ),
    KnownFailure(
        r"Invalid requirement: '?(?P<text>[^'\n]+)", "requirement", "{text} is not a requirement", _CORRECT_IT
    ),
)
_NETWORK = (
    KnownFailure(
        r"CERTIFICATE_VERIFY_FAILED[^\n]*(?:expired|not yet valid)",
        "network",
        "the package index's certificate is out of date by the robot's clock",
        "Set the clock of the robot: sudo timedatectl set-ntp true",
    ),
    KnownFailure(
        r"CERTIFICATE_VERIFY_FAILED",
        "network",
        "the robot rejects the package index's certificate",
        "Give the robot's pip the certificate of your network (pip config set global.cert FILE). Or use --offline",
    ),
    KnownFailure(
        r"Failed to establish a new connection|Max retries exceeded|Connection refused|ConnectTimeout"
        r"|Read timed out|name resolution|Network is unreachable|ProxyError",
        "network",
        "the robot does not reach the package index",
        "Connect it to a network, or push with --offline",
    ),
)
_NOT_FOUND = r"No matching distribution found for (?P<name>[^\s(]+)"
_UNKNOWN = KnownFailure(_NOT_FOUND, "requirement", "there is no {name} for {here}", _CORRECT_IT)
_NOT_UPLOADED = KnownFailure(
    _NOT_FOUND, "wheels", "no wheel of {name} for {here} was uploaded", "Push again with --offline"
)
_BUILDING = re.compile(r"Failed building wheel for|Failed to build|subprocess-exited-with-error")
_BUILT_PACKAGE = re.compile(r"Failed building wheel for ([\w.-]+)|╰─> ([\w.-]+)$|^Collecting ([\w.-]+)", re.MULTILINE)
_REASON = re.compile(r"^ *(.+)\n *\[end of output\]", re.MULTILINE)


def explain_failure(lines: Iterable[str], *, is_offline: bool) -> AgentError:
    """Return the error for the output of a pip that failed. For an unknown failure, it quotes the output.

    is_offline: whether pip installed uploaded wheels without the network.
    """
    output = "\n".join(lines)
    failures = (*_COMMON, _NOT_UPLOADED) if is_offline else (*_COMMON, *_NETWORK, _UNKNOWN)
    if known := explain_known(failures, output, here=_describe_python()):
        return known
    if _BUILDING.search(output):
        return _explain_build(output)
    return AgentError(f"pip failed on the robot: {_quote_errors(output)}", "Check the project's dependencies", "pip")


def _explain_build(output: str) -> AgentError:
    names = [name for found in _BUILT_PACKAGE.finditer(output) for name in found.groups() if name]
    reason = _REASON.findall(output)[-1:]
    name = names[-1] if names else "a requirement"
    problem = f"{name} has no wheel for {_describe_python()}, and cannot be built on the robot"
    remedy = "Use another version, or the system's package if there is one: sudo apt install python3-NAME"
    return AgentError(": ".join([problem, *reason]), remedy, "wheels")


def _describe_python() -> str:
    return f"Python {platform.python_version()} on {platform.machine()}"


def _quote_errors(output: str) -> str:
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    return " / ".join(errors[:3] or lines[-3:])
