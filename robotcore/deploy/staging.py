"""Select and copy the files of a folder that are sent: git's list, no secrets, no broken links."""

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
"""What editors, Python and its tools, version control and robots leave, by name; it is sent where git tracks it."""

RESULTS = ("sweeps", "recordings", "dist", "build")
"""Folders of a project's own that robotcore and builds make, at its top."""

ENVIRONMENT = "pyvenv.cfg"
"""A folder that has it is a virtual environment, whatever it is called."""

_GIT_VARIABLES = ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX")
"""What git tells its hooks, of another folder perhaps."""


@dataclass(frozen=True)
class Listing:
    """The files and links of a folder that are sent, by their names relative to it; and the secrets that are not."""

    names: tuple[str, ...]
    secrets: tuple[str, ...] = ()


def list_files(folder: Path) -> Listing:
    """Return the files of a folder that are sent, sorted, without secrets and without files that git ignores.

    Raises UsageError if a folder in it cannot be read.
    """
    try:
        of_git = _list_by_git(folder)
        found = sorted(set(_walk(folder, folder) if of_git is None else of_git))
    except OSError as error:
        raise UsageError(
            f"{escape(str(error.filename))}: {error.strerror}. Let it be read, or move it away", kind="unreadable-file"
        ) from error
    secrets = {name for name in found if is_secret(folder, name)}
    return Listing(tuple(name for name in found if name not in secrets), tuple(sorted(secrets)))


def _list_by_git(folder: Path) -> list[str] | None:
    """Return git's list of files; None if the folder is in no work tree or is ignored."""
    tracked = _ls_files(folder, "--cached")
    others = _ls_files(folder, "--others", "--exclude-standard")
    if tracked is None or others is None:
        return None
    environments = {Path(name).parent for name in others if Path(name).name == ENVIRONMENT}
    others = [name for name in others if not _is_generated(name) and environments.isdisjoint(Path(name).parents)]
    return list(_expand_repositories(folder, [*tracked, *others])) or None


def _ls_files(folder: Path, *which: str) -> list[str] | None:
    if (git := shutil.which("git")) is None:
        return None
    answer = subprocess.run(  # noqa: S603  words of our own, and no shell
        [git, "ls-files", "-z", *which],
        cwd=folder,
        env=git_environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    return None if answer.returncode else [os.fsdecode(name) for name in answer.stdout.split(b"\0") if name]


def git_environment() -> dict[str, str]:
    """Return an environment without git's variables, which a git hook would pass on."""
    return {name: value for name, value in os.environ.items() if name not in _GIT_VARIABLES}


def _expand_repositories(folder: Path, names: Iterable[str]) -> Iterator[str]:
    """Yield the files that are there; a folder stands for a repository in this one, and has its own list."""
    for name in names:
        path = folder / name
        if path.is_dir() and not path.is_symlink():
            inner = _list_by_git(path)
            yield from _walk(folder, path) if inner is None else (str(Path(name, each)) for each in inner)
        elif os.path.lexists(path):
            yield name


def _walk(folder: Path, below: Path) -> Iterator[str]:
    """Yield the files and links below, by their names from ``folder`` on, without what programs leave."""
    for path in below.iterdir():
        name = str(path.relative_to(folder))
        if _is_generated(name):
            continue
        if path.is_symlink() or not path.is_dir():
            yield name
        elif not (path / ENVIRONMENT).exists():
            yield from _walk(folder, path)


def _is_generated(name: str) -> bool:
    """Return whether a program generated the file or a folder that it is in."""
    parts = Path(name).parts
    return parts[0] in RESULTS or any(map(GENERATED.fullmatch, parts))


_FILES = re.compile(
    r""".*\.env(?:rc|\..*)?|.*\.(?:pem|key|p12|pfx|jks|keystore|kdbx|ppk|ovpn|psk|p8|pkcs12|tfstate)
    |ssh_host_.*_key|[._]netrc|\.pgpass|\.pypirc|\.npmrc|\.git-credentials|\.htpasswd|\.my\.cnf|\.dockercfg|\.s3cfg|\.boto
    |\.vault_pass|rclone\.conf|wpa_supplicant.*\.conf|.*\.nmconnection""",
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)
"""A file is secret if its whole name matches this."""

_WORDS = re.compile(
    r"""secret|credential|passw|token(?!i[sz])|api[_-]?key|kubeconfig|service[_-]?account|deploy[_-]?key|private[_-]?key
    |firebase-adminsdk|(?:\b|_)id_(?:rsa|dsa|ecdsa|ed25519)""",
    re.VERBOSE | re.IGNORECASE,
)
"""A file is secret if its name contains one of these words. Python files are exempt: the app may import them."""

_MODULES = re.compile(r"_*(?:secrets?|credentials?|passwords?|passwd|api_?keys?)\.pyi?", re.IGNORECASE)
"""A Python module is secret if its whole name matches this."""

_BACKUP = re.compile(r"(?:\.(?:bak|backup|old|orig|save|copy|tmp|\d+)|~)+", re.IGNORECASE)
_EXAMPLE = re.compile(r"\.(?:example|sample|template)(?:\.\w+)?|\.pub", re.IGNORECASE)
"""The ends of names. A backup is as secret as its original; an example and a public key are not secret."""

_WORD_FOLDERS = {"secret", "secrets", "credentials"}
"""All files in these folders are secret, except for Python files, examples and public keys."""

_FOLDERS = {".ssh", ".gnupg", ".aws", ".kube", ".secrets"}
_PLACES = {(".docker", "config.json")}
"""All files in these folders are secret, and these files in these folders."""

_PRIVATE_KEY = re.compile(
    rb"""^[\ \t\#>]*-{4}[-\ ]BEGIN\ [A-Z0-9\ ]*PRIVATE\ KEY  # at the beginning of a line, of a comment or a quotation
    |-----BEGIN\ [A-Z0-9\ ]*PRIVATE\ KEY[A-Z\ ]*-----(?:\\[rn]|[\s"'\\+])*[A-Za-z0-9+/]{16}  # or in a string of code
    |AGE-SECRET-KEY-1[A-Z0-9]{16}
    |^PuTTY-User-Key-File""",
    re.VERBOSE | re.MULTILINE,
)
_BEGINNING = 1 << 16
"""The bytes of a file that are searched for a private key."""


def is_secret(folder: Path, name: str) -> bool:
    """Return whether a file of a folder may hold a key, a password or a token. Public keys and examples do not."""
    path = Path(name)
    is_there = not _FOLDERS.isdisjoint(path.parts[:-1]) or path.parts[-2:] in _PLACES
    return is_there or _is_secret_name(path) or _is_private_key(folder / path)


def _is_secret_name(path: Path) -> bool:
    name = _without_end(_BACKUP, path.name)
    if _without_end(_EXAMPLE, name) != name:
        return False
    if name.lower().endswith((".py", ".pyi")):
        return bool(_MODULES.fullmatch(name))
    is_there = not _WORD_FOLDERS.isdisjoint(folder.lower() for folder in path.parts[:-1])
    return is_there or bool(_FILES.fullmatch(name) or _WORDS.search(name))


def _without_end(end: re.Pattern[str], name: str) -> str:
    return re.sub(rf"(?:{end.pattern})\Z", "", name, flags=end.flags)


def _is_private_key(file: Path) -> bool:
    """Return whether a file has a private key in its first 64 kB; one in UTF-16, or after a byte order mark, too."""
    if not file.is_file():
        return False
    try:
        with file.open("rb") as opened:
            beginning = opened.read(_BEGINNING)
    except OSError:  # the copy raises it, with its reason
        return False
    return bool(_PRIVATE_KEY.search(beginning.replace(b"\0", b"").removeprefix(b"\xef\xbb\xbf").lstrip(b"\xff\xfe")))


def copy_files(folder: Path, target: Path) -> Listing:
    """Copy what is sent of an absolute folder; a socket or a pipe is nobody's to send, and is passed over.

    A link is kept where it leads to something that is sent too, and made relative. Raises UsageError with all those
    that do not: they would lead to nothing there, or to somebody else's file.
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
            f"{escape(str(file))}: {error.strerror}. Let it be read, or let git ignore it", kind="unreadable-file"
        ) from error


def _find_links(folder: Path, names: Collection[str]) -> Iterator[tuple[str, str]]:
    """Yield the links among the names and where they lead, from beside them."""
    top = folder.resolve()
    sent = {Path(name) for name in names}
    sent |= {parent for path in sent for parent in path.parents}
    astray = []
    for name in names:
        if not (link := top / name).is_symlink():
            continue
        leads = Path(os.path.realpath(link))
        if leads.exists() and leads.is_relative_to(top) and leads.relative_to(top) in sent:
            yield name, os.path.relpath(leads, link.parent.resolve())
        else:
            astray.append(f"{name} -> {link.readlink()}")
    if astray:
        raise UsageError(
            f"{list_names(astray)}: a link that leads to nothing that is sent. Put the file itself there, or let git "
            "ignore the link",
            kind="link-leads-nowhere",
            links=tuple(astray),
        )
