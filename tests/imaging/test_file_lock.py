"""One program at a time holds a file, also where several ask for it in the moment another lets go."""

import errno
import os

import pytest

from relight_core.imaging import file_lock
from relight_core.imaging.file_lock import NoLocks, let_go, locked

posix = pytest.mark.skipif(os.name == "nt", reason="Windows removes no file that somebody has open")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "held.lock"


def before_the_next_lock(monkeypatch, happens):
    """Let something happen between the opening of a file and its locking, once."""
    lock = file_lock._lock

    def late(file):
        monkeypatch.setattr(file_lock, "_lock", lock)
        happens()
        lock(file)

    monkeypatch.setattr(file_lock, "_lock", late)


def test_a_file_has_one_holder_and_is_gone_after_the_last(path):
    file = locked(path)
    assert locked(path) is None
    let_go(file, path)
    again = locked(path)
    assert again is not None
    let_go(again, path)
    assert not path.exists()


@posix
def test_who_opened_the_file_before_it_was_let_go_does_not_hold_it_beside_the_next(path, monkeypatch):
    first, third = locked(path), []

    def another_takes_over():
        let_go(first, path)
        third.append(locked(path))

    before_the_next_lock(monkeypatch, another_takes_over)
    assert locked(path) is None
    assert third[0] is not None
    let_go(third[0], path)


@posix
def test_who_opened_the_file_before_it_was_let_go_holds_the_next_one(path, monkeypatch):
    first = locked(path)
    before_the_next_lock(monkeypatch, lambda: let_go(first, path))
    second = locked(path)
    assert second is not None
    assert path.exists()
    assert locked(path) is None
    let_go(second, path)


@posix
def test_nobody_takes_a_file_between_its_removal_and_its_release(path, monkeypatch):
    """Whoever could hold it while it still has its name would have it removed under them."""
    file, unlink, taken = locked(path), type(path).unlink, []

    def tried(self, **how):
        taken.append(locked(path))
        unlink(self, **how)

    monkeypatch.setattr(type(path), "unlink", tried)
    let_go(file, path)
    assert taken == [None]


@posix
def test_a_disk_that_can_t_tell_files_apart_has_no_locks(path, monkeypatch):
    monkeypatch.setattr(os.path, "samestat", lambda one, other: False)
    with pytest.raises(NoLocks):
        locked(path)


def test_a_disk_without_locks_is_none_where_another_program_holds_the_file(path, monkeypatch):
    def none(_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(file_lock, "_lock", none)
    with pytest.raises(NoLocks, match="No locks available"):
        locked(path)
