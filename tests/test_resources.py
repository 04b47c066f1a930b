"""Finding the files that travel with the project."""

import pytest

from relight_core.resources import resource_path


def test_bundled_files_are_found():
    assert resource_path("rigs").is_dir()
    assert resource_path("rigs", "ring.toml").is_file()


def test_what_is_missing_is_named():
    with pytest.raises(FileNotFoundError, match="no resource rigs/moon.toml"):
        resource_path("rigs", "moon.toml")
