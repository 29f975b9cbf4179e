"""Select and copy the files of a folder that a push sends.

These are the files that git lists, without secrets and without broken links.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from robotcore.errors import UsageError
from robotcore.text import escape, list_names

GENERATED = re.compile(
    r"""\.git|\.hg|\.svn|\.jj|__pycache__|\.venv|venv|\.tox|\.nox|node_modules|\.[a-z]+_cache|\.hypothesis|\.idea|\.vscode
    |\.ipynb_checkpoints|\.DS_Store|\.coverage|.*\.egg-info|.*\.py[co]|.*\.mcap|.+~|\.\#.*|.*\.sw[po]""",
    re.VERBOSE | re.DOTALL,
)
"""The names of files and folders that programs generate. They are not sent unless git tracks them."""

RESULT_FOLDERS = ("sweeps", "recordings", "dist", "build")
"""The folders directly in a project's folder that robotcore and build tools make."""

VENV_FILE = "pyvenv.cfg"
"""A folder with a file of this name is a virtual environment."""

_GIT_VARIABLES = ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX")
"""Variables that git sets for its hooks. They may name another repository."""


@dataclass(frozen=True)
class Listing:
    """The files of a folder, as paths relative to that folder."""

    names: tuple[str, ...]
    """The files and links that are sent."""
    secrets: tuple[str, ...] = ()
    """The files that are not sent, because they may hold a secret."""


def list_files(folder: Path) -> Listing:
    """Return the files of a folder that are sent, sorted, without secrets and without files that git ignores.

    Raises UsageError if a folder in it cannot be read.
    """
    try:
        of_git = _list_by_git(folder)
        found = sorted(set(_walk(folder, folder) if of_git is None else of_git))
    except OSError as error:
        raise UsageError(
            f"{escape(str(error.filename))}: {error.strerror}. Make it readable, or move it out of the project",
            kind="unreadable-file",
        ) from error
    secrets = {name for name in found if is_secret(folder, name)}
    return Listing(tuple(name for name in found if name not in secrets), tuple(sorted(secrets)))


def _list_by_git(folder: Path) -> list[str] | None:
    """Return the files that git lists in a folder; None if the folder is in no work tree of git, or git ignores it."""
    tracked = _ls_files(folder, "--cached")
    others = _ls_files(folder, "--others", "--exclude-standard")
    if tracked is None or others is None:
        return None
    environments = {Path(name).parent for name in others if Path(name).name == VENV_FILE}
    others = [name for name in others if not _is_generated(name) and environments.isdisjoint(Path(name).parents)]
    return list(_expand_repositories(folder, [*tracked, *others])) or None


def _ls_files(folder: Path, *which: str) -> list[str] | None:
    if (git := shutil.which("git")) is None:
        return None
    answer = subprocess.run(  # noqa: S603  no shell
        [git, "ls-files", "-z", *which],
        cwd=folder,
        env=build_git_environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    return None if answer.returncode else [os.fsdecode(name) for name in answer.stdout.split(b"\0") if name]


def build_git_environment() -> dict[str, str]:
    """Return the environment without the variables that git sets for its hooks."""
    return {name: value for name, value in os.environ.items() if name not in _GIT_VARIABLES}


def _expand_repositories(folder: Path, names: Iterable[str]) -> Iterator[str]:
    """Yield those names in git's list whose files exist.

    A folder in this list is a nested repository. It is replaced by its own files.
    """
    for name in names:
        path = folder / name
        if path.is_dir() and not path.is_symlink():
            inner = _list_by_git(path)
            yield from _walk(folder, path) if inner is None else (str(Path(name, each)) for each in inner)
        elif os.path.lexists(path):
            yield name


def _walk(folder: Path, below: Path) -> Iterator[str]:
    """Yield the files and links below a folder, as paths relative to ``folder``, without generated files."""
    for path in below.iterdir():
        name = str(path.relative_to(folder))
        if _is_generated(name):
            continue
        if path.is_symlink() or not path.is_dir():
            yield name
        elif not (path / VENV_FILE).exists():
            yield from _walk(folder, path)


def _is_generated(name: str) -> bool:
    """Return whether a program generated the file, or one of the folders that contain the file."""
    parts = Path(name).parts
    return parts[0] in RESULT_FOLDERS or any(map(GENERATED.fullmatch, parts))


_SECRET_FILES = re.compile(
    r""".*\.env(?:rc|\..*)?|.*\.(?:pem|key|p12|pfx|jks|keystore|kdbx|ppk|ovpn|psk|p8|pkcs12|tfstate)
    |ssh_host_.*_key|[._]netrc|\.pgpass|\.pypirc|\.npmrc|\.git-credentials|\.htpasswd|\.my\.cnf|\.dockercfg|\.s3cfg|\.boto
    |\.vault_pass|rclone\.conf|wpa_supplicant.*\.conf|.*\.nmconnection""",
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)
"""A file is secret if its whole name matches this pattern."""

_SECRET_WORDS = re.compile(
    r"""secret|credential|passw|token(?!i[sz])|api[_-]?key|kubeconfig|service[_-]?account|deploy[_-]?key|private[_-]?key
    |firebase-adminsdk|(?:\b|_)id_(?:rsa|dsa|ecdsa|ed25519)""",
    re.VERBOSE | re.IGNORECASE,
)
"""A file is secret if its name contains one of these words, unless it is a Python file, which the app may import."""

_SECRET_MODULES = re.compile(r"_*(?:secrets?|credentials?|passwords?|passwd|api_?keys?)\.pyi?", re.IGNORECASE)
"""A Python file is secret if its whole name matches this pattern."""

_BACKUP = re.compile(r"(?:\.(?:bak|backup|old|orig|save|copy|tmp|\d+)|~)+", re.IGNORECASE)
_EXAMPLE = re.compile(r"\.(?:example|sample|template)(?:\.\w+)?|\.pub", re.IGNORECASE)
"""Endings of file names. A backup is as secret as the original file. An example or a public key is not secret."""

_SECRET_WORD_FOLDERS = {"secret", "secrets", "credentials"}
"""All files in these folders are secret, except for Python files, examples and public keys."""

_SECRET_FOLDERS = {".ssh", ".gnupg", ".aws", ".kube", ".secrets"}
_SECRET_PLACES = {(".docker", "config.json")}
"""Folders whose files are all secret, and single files in a folder that are secret."""

_PRIVATE_KEY = re.compile(
    rb"""^[\ \t\#>]*-{4}[-\ ]BEGIN\ [A-Z0-9\ ]*PRIVATE\ KEY  # at the beginning of a line, a comment or a quotation
    |-----BEGIN\ [A-Z0-9\ ]*PRIVATE\ KEY[A-Z\ ]*-----(?:\\[rn]|[\s"'\\+])*[A-Za-z0-9+/]{16}  # or in a string of code
    |AGE-SECRET-KEY-1[A-Z0-9]{16}
    |^PuTTY-User-Key-File""",
    re.VERBOSE | re.MULTILINE,
)
_BEGINNING = 1 << 16
"""The function that detects a private key searches this many bytes of a file."""


def is_secret(folder: Path, name: str) -> bool:
    """Return whether a file of a folder may hold a key, a password or a token.

    folder: the project's folder.
    name: the file, relative to it.
    """
    path = Path(name)
    is_in_place = not _SECRET_FOLDERS.isdisjoint(path.parts[:-1]) or path.parts[-2:] in _SECRET_PLACES
    return is_in_place or _is_secret_name(path) or _has_private_key(folder / path)


def _is_secret_name(path: Path) -> bool:
    name = _remove_end(_BACKUP, path.name)
    if _remove_end(_EXAMPLE, name) != name:
        return False
    if name.lower().endswith((".py", ".pyi")):
        return bool(_SECRET_MODULES.fullmatch(name))
    is_in_folder = not _SECRET_WORD_FOLDERS.isdisjoint(folder.lower() for folder in path.parts[:-1])
    return is_in_folder or bool(_SECRET_FILES.fullmatch(name) or _SECRET_WORDS.search(name))


def _remove_end(end: re.Pattern[str], name: str) -> str:
    return re.sub(rf"(?:{end.pattern})\Z", "", name, flags=end.flags)


def _has_private_key(file: Path) -> bool:
    """Return whether the first 64 kB of a file contain a private key, as text in ASCII, UTF-8 or UTF-16."""
    if not file.is_file():
        return False
    try:
        with file.open("rb") as opened:
            beginning = opened.read(_BEGINNING)
    except OSError:  # the copy of this file raises the same error
        return False
    return bool(_PRIVATE_KEY.search(beginning.replace(b"\0", b"").removeprefix(b"\xef\xbb\xbf").lstrip(b"\xff\xfe")))


def copy_files(folder: Path, target: Path) -> Listing:
    """Copy the files that a push sends; return the names of these files and of those that may hold a secret.

    Sockets and pipes are left out. A link to another file that is sent becomes a relative link.

    folder: the project's folder, absolute.
    target: the folder for the copy.
    Raises UsageError with all links that lead to no file that is sent, because they would be broken on the robot.
    """
    listing = list_files(folder)
    links = dict(_find_links(folder, listing.names))
    for name in listing.names:
        place = target / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if name in links:
            place.symlink_to(links[name])
        elif (folder / name).is_file():
            _copy_file(folder / name, place)
    return listing


def _copy_file(file: Path, place: Path) -> None:
    try:
        shutil.copy(file, place)
    except OSError as error:
        raise UsageError(
            f"{escape(str(file))}: {error.strerror}. Make it readable, or let git ignore it", kind="unreadable-file"
        ) from error


def _find_links(folder: Path, names: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield the links among the names, each with its target relative to the link's folder."""
    top = folder.resolve()
    sent = {Path(name) for name in names}
    sent |= {parent for path in sent for parent in path.parents}
    broken = []
    for name in names:
        if not (link := top / name).is_symlink():
            continue
        target = Path(os.path.realpath(link))
        if target.exists() and target.is_relative_to(top) and target.relative_to(top) in sent:
            yield name, os.path.relpath(target, link.parent.resolve())
        else:
            broken.append(f"{name} -> {link.readlink()}")
    if broken:
        raise UsageError(
            f"{list_names(broken)}: the link does not lead to a file that is sent. Replace the link by the file, or "
            "let git ignore it",
            kind="link-leads-nowhere",
            links=tuple(broken),
        )
