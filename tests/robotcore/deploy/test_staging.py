from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from robotcore.deploy.staging import copy_files, list_files
from robotcore.errors import UsageError
from tests.robotcore.deploy.projects import git, write
from tests.texts import Raises

HOSTILE = ("a b.py", "it's \"$(x)`y`;.py", "new\nline.py", "-rf", "--help", "é\u200b字.py", "*", "~", "back\\slash")
GENERATED = {
    "__pycache__/app.cpython-311.pyc": "",
    ".venv/bin/python": "",
    "env/pyvenv.cfg": "",
    "env/lib/x.py": "",
    "sweeps/a/results.jsonl": "",
    "recordings/rover/1.mcap": "",
    "run.mcap": "",
    ".pytest_cache/x": "",
    ".#app.py": "",
}
SECRETS = {
    ".env": "A=1",
    ".envrc": "export A=1",
    "production.env": "A=1",
    "deep/.env.local": "A=1",
    "tls.pem": "",
    "id_ed25519": "",
    ".ssh/config": "",
    "harmless.txt": "-----BEGIN OPENSSH PRIVATE KEY-----\n",
}
PUBLIC = {"app.py": "", "id_tags.py": "", ".env.example": "", "id_ed25519.pub": "", "keys.md": "see -----BEGIN"}

KEY = "-----BEGIN RSA PRIVATE KEY-----\nMIIEowIBAAKCAQEA1c7+9z5Pad7Oejec\n"
SECRET_NAMES = [
    "secret.txt",
    "client_secret_123.json",
    "credentials",
    "service-account.json",
    "token.txt",
    "api_key.txt",
    ".pgpass",
    ".netrc",
    ".docker/config.json",
    ".kube/config",
    "deploy_key",
    "key.pem.bak",
    "wifi.psk",
    "SECRETS.TOML",
    "secrets.py",
    "password.py",
    "secrets/wifi.txt",
    "credentials/prod.yaml",
    "secrets/password.py",
    "private_key",
    "robot_id_rsa",
    "ssh_host_ed25519_key",
    "AuthKey.p8",
    "a.pkcs12",
    "wpa_supplicant-wlan0.conf",
    "rclone.conf",
    ".my.cnf",
    ".dockercfg",
    ".s3cfg",
    ".boto",
    "terraform.tfstate",
    ".vault_pass",
    "rover-firebase-adminsdk-x1.json",
]
SENT_NAMES = [
    "tokens.py",
    "token.py",
    "tokenizer.py",
    "password_field.py",
    "test_secrets.py",
    "secret_garden.py",
    "config.json",
    "credentials.json.sample",
    "deploy_key.pub",
    "secrets/__init__.py",
    "secrets/wifi.toml.example",
    "ssh_host_rsa_key.pub",
    "grid_rsa.txt",
    "secretary/notes.txt",
    ".docker/Dockerfile",
]
KEYS = {
    "after attributes": f"Bag Attributes\n    friendlyName: x\nKey Attributes: <No Attributes>\n{KEY}".encode(),
    "after a mark": b"\xef\xbb\xbf" + KEY.encode(),
    "in UTF-16": KEY.encode("utf-16"),
    "in JSON": json.dumps({"private_key": KEY}).encode(),
    "in code": f'KEY = """{KEY}"""'.encode(),
    "deep": b"#\n" * 30_000 + KEY.encode(),
    "in a comment": b"# " + KEY.encode().replace(b"\n", b"\n# "),
    "in a quotation": b"> " + KEY.encode(),
    "of age": b"# created: today\nAGE-SECRET-KEY-1QQPQZRY9X8GF2TVDW0S3JN54KHCE6MUA7L\n",
    "of SSH2": b"---- BEGIN SSH2 ENCRYPTED PRIVATE KEY ----\nComment: x\n",
}


def test_file_with_the_name_of_a_secret_is_not_sent(tmp_path: Path) -> None:
    for number, name in enumerate(SECRET_NAMES):
        assert list_files(write(tmp_path / str(number), {name: ""})).secrets == (name,)


def test_code_and_examples_with_such_a_word_in_their_name_are_sent(tmp_path: Path) -> None:
    for number, name in enumerate(SENT_NAMES):
        assert list_files(write(tmp_path / str(number), {name: ""})).names == (name,)


def test_file_with_a_private_key_is_not_sent(tmp_path: Path) -> None:
    for case, content in KEYS.items():
        (tmp_path / "notes.txt").write_bytes(content)
        assert list_files(tmp_path).secrets == ("notes.txt",), case


def test_public_key_and_text_about_keys_are_sent(tmp_path: Path) -> None:
    write(
        tmp_path,
        {"a.txt": KEY.replace("RSA PRIVATE", "PUBLIC"), "b.md": "A file `-----BEGIN PRIVATE KEY-----` is one."},
    )
    assert list_files(tmp_path).names == ("a.txt", "b.md")


@pytest.mark.parametrize("has_git", [False, True])
def test_generated_files_and_secrets_are_not_sent_and_secrets_are_reported(tmp_path: Path, *, has_git: bool) -> None:
    write(tmp_path, {**GENERATED, **SECRETS, **PUBLIC})
    if has_git:
        git(tmp_path, "init", "-q")
    assert set(list_files(tmp_path).names) == set(PUBLIC)
    assert set(list_files(tmp_path).secrets) == set(SECRETS)


def test_git_decides_which_files_are_sent(tmp_path: Path) -> None:
    write(tmp_path, {".gitignore": "big*\n", "big.bin": "", "run.mcap": "", "gone.py": "", ".env": "", "new.py": ""})
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", "-f", "run.mcap", "gone.py", ".env")
    (tmp_path / "gone.py").unlink()
    assert list_files(tmp_path).names == (".gitignore", "new.py", "run.mcap")
    assert list_files(tmp_path).secrets == (".env",), "even if git tracks it"


def test_nested_repository_is_sent(tmp_path: Path) -> None:
    write(tmp_path, {"app.py": "", "lib/.gitignore": "junk\n", "lib/junk": "", "lib/lib.py": ""})
    for folder in (tmp_path, tmp_path / "lib"):
        git(folder, "init", "-q")
    assert list_files(tmp_path).names == ("app.py", "lib/.gitignore", "lib/lib.py")


def test_ignored_folder_as_the_project_is_sent(tmp_path: Path) -> None:
    write(tmp_path, {".gitignore": "tried/\n", "tried/app.py": ""})
    git(tmp_path, "init", "-q")
    assert list_files(tmp_path / "tried").names == ("app.py",)


def test_a_hook_of_another_repository_does_not_change_the_list(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("one", "other"):
        git(write(tmp_path / name, {f"{name}.py": "", ".gitignore": "big\n", "big": ""}), "init", "-q")
    monkeypatch.setenv("GIT_DIR", str(tmp_path / "other" / ".git"))
    monkeypatch.setenv("GIT_WORK_TREE", str(tmp_path / "other"))
    assert list_files(tmp_path / "one").names == (".gitignore", "one.py")


@pytest.mark.parametrize("has_git", [False, True])
def test_file_names_are_copied_unchanged(tmp_path: Path, *, has_git: bool) -> None:
    source, target = write(tmp_path / "source", {name: name for name in HOSTILE}), tmp_path / "target"
    (source / os.fsdecode(b"latin-\xe9")).write_text("x")
    if has_git:
        git(source, "init", "-q")
    copy_files(source, target)
    assert {path.name for path in target.iterdir()} == {path.name for path in source.iterdir()} - {".git"}
    assert all((target / name).read_text() == name for name in HOSTILE)


def test_link_to_a_sent_file_is_made_relative(tmp_path: Path) -> None:
    source = write(tmp_path / "source", {"data/map.txt": "here"})
    (source / "absolute").symlink_to(source / "data" / "map.txt")
    (source / "data" / "round").symlink_to("../../source/data/map.txt")
    (source / "folder").symlink_to("data")
    copy_files(source, tmp_path / "target")
    source.rename(tmp_path / "moved")
    for name in ("absolute", "data/round", "folder/map.txt"):
        assert (tmp_path / "target" / name).read_text() == "here"
    assert (tmp_path / "target" / "absolute").is_symlink()


@pytest.mark.parametrize("target", ["nowhere", "../outside.txt", "/etc/passwd", ".env", "loop"])
def test_link_to_a_file_that_is_not_sent_is_refused(tmp_path: Path, target: str, raises: Raises) -> None:
    source = write(tmp_path, {"outside.txt": "", "source/.env": "", "source/app.py": ""}) / "source"
    (source / "loop").symlink_to(target)
    with raises(UsageError, "link-leads-nowhere", links=(f"loop -> {target}",)):
        copy_files(source, tmp_path / "target")


def test_pipe_is_left_out(tmp_path: Path) -> None:
    source = write(tmp_path / "source", {"app.py": ""})
    os.mkfifo(source / "pipe")
    copy_files(source, tmp_path / "target")
    assert [path.name for path in (tmp_path / "target").iterdir()] == ["app.py"]
