"""Files that may hold a secret, by their names or by what they begin with: none of them leaves the desk."""

from __future__ import annotations

import re
from pathlib import Path

_NAMES = re.compile(
    r"""\.env(?!\.(?:example|sample|template)$)(?:rc|\..*)?|.*\.(?:env|pem|key|p12|pfx|jks|keystore|kdbx|ppk|ovpn)
    |id_(?:rsa|dsa|ecdsa|ed25519)(?:_sk)?|\.netrc|\.pypirc|\.npmrc|\.git-credentials|\.htpasswd
    |(?:credentials|secrets?)\.(?:json|ya?ml|toml|ini)|wpa_supplicant\.conf|.*\.nmconnection""",
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)
_FOLDERS = {".ssh", ".gnupg", ".aws", ".secrets"}
_PRIVATE_KEY = re.compile(rb"\s*-----BEGIN [A-Z0-9 ]*PRIVATE KEY|PuTTY-User-Key-File")
_BEGINNING = 200


def is_secret(folder: Path, name: str) -> bool:
    """Return whether a file of a folder may hold a key, a password or a token. Public keys and examples do not."""
    path = Path(name)
    return bool(_NAMES.fullmatch(path.name)) or not _FOLDERS.isdisjoint(path.parts) or _is_private_key(folder / path)


def _is_private_key(file: Path) -> bool:
    if not file.is_file():
        return False
    try:
        with file.open("rb") as opened:
            return bool(_PRIVATE_KEY.match(opened.read(_BEGINNING)))
    except OSError:  # told when it is to be sent
        return False
