"""Files that may hold a secret, by their names or by what they begin with: none of them leaves the desk."""

from __future__ import annotations

import re
from pathlib import Path

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
