"""What the tests of autosave share."""

import pytest

from app.document.autosave import Autosave


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "kept"


@pytest.fixture
def autosave(folder):
    return Autosave(folder, lambda write: write())
