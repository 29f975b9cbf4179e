from __future__ import annotations

from pathlib import Path

import pytest

from tests.docs.listings import list_listings

README = (Path(__file__).parents[2] / "README.md").read_text()


@pytest.mark.slow
def test_test_of_the_readme_passes_with_its_app(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    app, prompt, test = (each.text for each in list_listings(README) if each.language == "python")
    (tmp_path / "reflex.py").write_text(app)
    (tmp_path / "readme_test.py").write_text(test)
    monkeypatch.syspath_prepend(tmp_path)
    assert pytest.main(["-q", "-p", "no:cacheprovider", str(tmp_path / "readme_test.py")]) == 0
    monkeypatch.chdir(tmp_path)
    exec(compile(prompt, "first_drive.py", "exec"), {})  # noqa: S102
    assert (tmp_path / "robot.png").is_file()
