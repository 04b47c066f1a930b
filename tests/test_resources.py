"""Finding the files that travel with the project."""

import pytest

from relight_core import resources
from relight_core.errors import InputError
from relight_core.resources import resource_path


def test_bundled_files_are_found():
    assert resource_path("rigs").is_dir()
    assert resource_path("rigs", "ring.toml").is_file()


def test_what_is_missing_is_named():
    with pytest.raises(FileNotFoundError, match="no resource rigs/moon.toml"):
        resource_path("rigs", "moon.toml")


def test_an_installation_without_them_is_told_in_a_line(monkeypatch, tmp_path):
    monkeypatch.setattr(resources, "_ROOT", tmp_path / "resources")
    with pytest.raises(InputError, match="make setup"):
        resource_path("rigs")
