"""Selects and copies the files of a project that a push sends: the files that git lists, without secrets."""

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
"""The names of folders that robotcore and build tools make directly in a project's folder."""

VENV_FILE = "pyvenv.cfg"
"""The name of a file that every virtual environment has."""

_GIT_VARIABLES = ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX")
"""The environment variables that git sets for its hooks. They may name another repository."""


@dataclass(frozen=True)
class Listing:
    """The files of a folder: their paths relative to the folder."""

    names: tuple[str, ...]
    """The files and links that are sent."""
    secrets: tuple[str, ...] = ()
    """The files that are not sent because they may hold a secret."""


def list_files(folder: Path) -> Listing:
    """Return the files of a folder, sorted, without the files that git ignores and without generated files.

    Raises UsageError if a file or a folder in it cannot be read.
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
    """Return the files that git lists in a folder. Return None if git is missing, or if git ignores the folder."""
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
    """Yield the names of existing files in git's list.

    A folder in the list is a nested repository. The function yields its files instead.
    """
    for name in names:
        path = folder / name
        if path.is_dir() and not path.is_symlink():
            inner = _list_by_git(path)
            yield from _walk(folder, path) if inner is None else (str(Path(name, each)) for each in inner)
        elif os.path.lexists(path):
            yield name


def _walk(folder: Path, below: Path) -> Iterator[str]:
    """Yield the files and links in the folder ``below``, as paths relative to ``folder``, without generated files."""
    for path in below.iterdir():
        name = str(path.relative_to(folder))
        if _is_generated(name):
            continue
        if path.is_symlink() or not path.is_dir():
            yield name
        elif not (path / VENV_FILE).exists():
            yield from _walk(folder, path)


def _is_generated(name: str) -> bool:
    parts = Path(name).parts
    return parts[0] in RESULT_FOLDERS or any(map(GENERATED.fullmatch, parts))


_SECRET_FILES = re.compile(
    r""".*\.env(?:rc|\..*)?|.*\.(?:pem|key|p12|pfx|jks|keystore|kdbx|ppk|ovpn|psk|p8|pkcs12|tfstate)
    |ssh_host_.*_key|[._]netrc|\.pgpass|\.pypirc|\.npmrc|\.git-credentials|\.htpasswd|\.my\.cnf|\.dockercfg|\.s3cfg|\.boto
    |\.vault_pass|rclone\.conf|wpa_supplicant.*\.conf|.*\.nmconnection""",
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)
"""The pattern of the whole name of a secret file."""

_SECRET_WORDS = re.compile(
    r"""secret|credential|passw|token(?!i[sz])|api[_-]?key|kubeconfig|service[_-]?account|deploy[_-]?key|private[_-]?key
    |firebase-adminsdk|(?:\b|_)id_(?:rsa|dsa|ecdsa|ed25519)""",
    re.VERBOSE | re.IGNORECASE,
)
"""The words in the name of a secret file. They do not apply to Python files, which the app may import."""

_SECRET_MODULES = re.compile(r"_*(?:secrets?|credentials?|passwords?|passwd|api_?keys?)\.pyi?", re.IGNORECASE)
"""The pattern of the whole name of a secret Python file."""

_BACKUP = re.compile(r"(?:\.(?:bak|backup|old|orig|save|copy|tmp|\d+)|~)+", re.IGNORECASE)
"""The pattern of the ending of a backup's name. A backup is as secret as its original."""

_EXAMPLE = re.compile(r"\.(?:example|sample|template)(?:\.\w+)?|\.pub", re.IGNORECASE)
"""The pattern of the ending of an example's or a public key's name. Neither is secret."""

_SECRET_WORD_FOLDERS = {"secret", "secrets", "credentials"}
"""The names of folders whose files are secret, except for Python files, examples and public keys."""

_SECRET_FOLDERS = {".ssh", ".gnupg", ".aws", ".kube", ".secrets"}
"""The names of folders whose files are all secret."""

_SECRET_PLACES = {(".docker", "config.json")}
"""The folder and the name of each secret file whose name alone is not secret."""

_PRIVATE_KEY = re.compile(
    rb"""^[\ \t\#>]*-{4}[-\ ]BEGIN\ [A-Z0-9\ ]*PRIVATE\ KEY  # at the beginning of a line, a comment or a quotation
    |-----BEGIN\ [A-Z0-9\ ]*PRIVATE\ KEY[A-Z\ ]*-----(?:\\[rn]|[\s"'\\+])*[A-Za-z0-9+/]{16}  # or in a string of code
    |AGE-SECRET-KEY-1[A-Z0-9]{16}
    |^PuTTY-User-Key-File""",
    re.VERBOSE | re.MULTILINE,
)
_BEGINNING = 1 << 16
"""The number of bytes at the beginning of a file in which a private key is searched."""


def is_secret(folder: Path, name: str) -> bool:
    """Return whether a file may hold a key, a password or a token.

    folder: the project's folder.
    name: the file's path relative to that folder.
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
    """Return whether the beginning of a file has a private key as text, in ASCII, UTF-8 or UTF-16."""
    if not file.is_file():
        return False
    try:
        with file.open("rb") as opened:
            beginning = opened.read(_BEGINNING)
    except OSError:  # the copy of this file raises the same error
        return False
    return bool(_PRIVATE_KEY.search(beginning.replace(b"\0", b"").removeprefix(b"\xef\xbb\xbf").lstrip(b"\xff\xfe")))


def copy_files(folder: Path, target: Path) -> Listing:
    """Copy the files of a folder that a push sends, and return the result of `list_files`.

    The function leaves out sockets and pipes. A link to another file that is sent becomes a relative link.

    folder: the absolute path of the project's folder.
    target: the folder for the copy.
    Raises UsageError for links that would be broken on the robot.
    """
    listing = list_files(folder)
    links = dict(_find_sent_links(folder, listing.names))
    for name in listing.names:
        place = target / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if name in links:
            place.symlink_to(links[name])
        elif (folder / name).is_file():
            try:
                shutil.copy(folder / name, place)
            except OSError as error:
                raise UsageError(
                    f"{escape(str(folder / name))}: {error.strerror}. Make it readable, or let git ignore it",
                    kind="unreadable-file",
                ) from error
    return listing


def _find_sent_links(folder: Path, names: Collection[str]) -> Iterator[tuple[str, str]]:
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
