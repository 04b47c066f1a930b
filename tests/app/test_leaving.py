"""Closing the window never throws away files without a word."""

import threading

import glfw
import pytest
from fake_relighter import LONG_S

from app.document.autosave import leftovers
from app.engine.jobs import Jobs
from app.ui.asking import Asking
from app.window.leaving import Leaving
from app.window.window import EditorWindow
from relight_core.errors import InputError


class Work:
    """Files being made, and how many could not be."""

    def __init__(self):
        self.busy, self.failures, self.asking = True, 0, Asking()
        self.loses_work = False
        self.leaving = Leaving(self.asking, lambda: self.busy, lambda: self.failures, lambda: self.loses_work)

    def choose(self, label):
        (question,) = self.asking.questions
        self.asking.drop(question.key)
        dict(question.choices)[label]()


@pytest.fixture
def work():
    return Work()


def test_with_nothing_to_finish_the_window_closes_unasked(work):
    work.busy = False
    assert not work.leaving.allows(wanted=False)
    assert work.leaving.allows(wanted=True)
    assert work.asking.questions == []


def test_what_is_being_made_can_be_finished_first(work):
    assert not work.leaving.allows(wanted=True)
    work.choose("Finish first")
    assert not work.leaving.allows(wanted=False)
    work.busy = False
    assert work.leaving.allows(wanted=False)


def test_that_the_window_will_close_is_in_sight_and_can_be_called_off_until_it_does(work):
    work.leaving.allows(wanted=True)
    work.choose("Finish first")
    assert not work.leaving.allows(wanted=False)
    (question,) = work.asking.questions
    assert question.text == "This window closes once the files you asked for are made."
    assert [label for label, _ in question.choices] == ["Stay open"]
    assert work.asking.call_off()
    work.busy = False
    assert not work.leaving.allows(wanted=False)
    assert work.asking.questions == []


def test_what_could_not_be_finished_is_told_before_the_window_closes(work):
    work.failures = 1
    work.leaving.allows(wanted=True)
    work.choose("Finish first")
    work.busy, work.failures = False, 2
    assert not work.leaving.allows(wanted=False)
    assert work.asking.questions == []
    assert work.leaving.allows(wanted=True)


def test_whoever_has_not_answered_by_the_time_it_is_made_is_asked_no_more(work):
    work.leaving.allows(wanted=True)
    assert not work.leaving.allows(wanted=False)
    assert len(work.asking.questions) == 1
    work.busy = False
    assert not work.leaving.allows(wanted=False)
    assert work.asking.questions == []
    assert work.leaving.allows(wanted=True)


def test_it_can_be_stopped_or_the_window_stay_open(work):
    work.leaving.allows(wanted=True)
    work.choose("Stay open")
    work.busy = False
    assert not work.leaving.allows(wanted=False)
    work.busy = True
    work.leaving.allows(wanted=True)
    work.choose("Stop it")
    assert work.leaving.allows(wanted=False)


def test_whoever_then_wants_the_window_to_stay_open_keeps_it(work):
    for answer in ("Finish first", "Stay open"):
        work.leaving.allows(wanted=True)
        work.choose(answer)
    work.busy = False
    assert not work.leaving.allows(wanted=False)


@pytest.mark.parametrize("answer", ["Finish first", "Stop it"])
def test_whoever_stays_for_work_that_would_be_lost_is_asked_no_more(work, answer):
    work.leaving.allows(wanted=True)
    work.choose(answer)
    work.busy, work.loses_work = False, True
    assert not work.leaving.allows(wanted=False)
    work.choose("Stay open")
    assert not work.leaving.allows(wanted=False)
    assert work.asking.questions == []


@pytest.mark.parametrize("busy", [True, False])
def test_the_answers_that_enter_and_escape_give_lose_nothing(work, busy):
    work.busy, work.loses_work = busy, not busy
    work.leaving.allows(wanted=True)
    (question,) = work.asking.questions
    assert (question.choices[0][0], question.calling_off) == ("Finish first" if busy else "Stay open", "Stay open")


def test_jobs_are_busy_until_what_became_of_them_is_told():
    began, go_on, at_end = threading.Event(), threading.Event(), []
    jobs = Jobs(lambda text, is_error: at_end.append(jobs.is_busy()))

    def work(control):
        began.set()
        assert go_on.wait(LONG_S)
        raise InputError("full")

    assert not jobs.is_busy()
    jobs.start("Export", work)
    assert began.wait(LONG_S)
    assert jobs.is_busy()
    go_on.set()
    jobs.close()
    assert at_end == [True]
    assert not jobs.is_busy()
    assert jobs.failures == 1


def test_a_file_that_failed_keeps_the_window_open_though_a_later_one_was_saved():
    asking, go_on, said = Asking(), threading.Event(), []
    jobs = Jobs(lambda text, is_error: said.append((text, is_error)))
    leaving = Leaving(asking, jobs.is_busy, lambda: jobs.failures)

    def fail(control):
        assert go_on.wait(LONG_S)
        raise InputError("full")

    jobs.start("Export", fail)
    jobs.start("Export", lambda control: "Saved b.png")
    assert not leaving.allows(wanted=True)
    dict(asking.questions[0].choices)["Finish first"]()
    go_on.set()
    jobs.close()
    assert said == [("full", True), ("Saved b.png", False)]
    assert not leaving.allows(wanted=False)
    assert leaving.allows(wanted=True)


def test_the_window_stays_for_an_export_that_waits_for_its_picture(opened, relighter, photo_path):
    window = opened.window
    relighter.gate.clear()
    opened.move(opened.centre())
    window.on_wheel(None, 0.0, 7.0)
    opened.frames(3)
    opened.hold(glfw.KEY_E)
    opened.release(glfw.KEY_E)
    glfw.set_window_should_close(window.handle, True)
    assert not window.may_close()
    assert not glfw.window_should_close(window.handle)
    (question,) = window.state.asking.questions
    relighter.gate.set()
    dict(question.choices)["Finish first"]()
    window.run()
    assert photo_path.with_name("person-relit.png").exists()


def test_the_window_closes_by_its_key_as_by_its_button(opened, relighter):
    window = opened.window
    relighter.gate.clear()
    window.state.turn(5.0)
    opened.frames(3)
    for key, mods in ((glfw.KEY_E, 0), (glfw.KEY_Q, glfw.MOD_CONTROL)):
        opened.hold(key, mods)
        opened.release(key)
    assert not window.may_close(), "a file is still being made"
    (question,) = window.state.asking.questions
    assert [label for label, _ in question.choices] == ["Finish first", "Stop it", "Stay open"]
    opened.frames(3)
    dict(question.choices)["Stay open"]()
    relighter.gate.set()
    opened.settle()
    window.exporter.close()
    opened.frames(3)
    assert not window.may_close(), "whoever stayed wants to go on"
    opened.key(glfw.KEY_Q, ctrl=True)
    assert window.may_close()


def test_work_that_can_not_be_kept_is_lost_only_if_the_user_says_so(work):
    work.busy, work.loses_work = False, True
    assert not work.leaving.allows(wanted=True)
    work.choose("Stay open")
    assert not work.leaving.allows(wanted=False)
    assert work.asking.questions == []
    assert not work.leaving.allows(wanted=True)
    work.choose("Close anyway")
    assert work.leaving.allows(wanted=False)


def test_stopping_what_is_being_made_loses_no_work_unasked(work):
    work.loses_work = True
    work.leaving.allows(wanted=True)
    work.choose("Stop it")
    assert not work.leaving.allows(wanted=False)
    work.choose("Stay open")
    assert not work.leaving.allows(wanted=False)
    work.loses_work = False
    work.busy = False
    assert work.leaving.allows(wanted=True)


def test_a_window_whose_work_can_not_be_kept_asks_before_it_closes(display, photo_path, relighter, tmp_path):
    (tmp_path / "taken").touch()
    window = EditorWindow(lambda: relighter, photo_path, settings_path=tmp_path / "taken" / "settings.json")
    try:
        window.settle(LONG_S)
        window.state.change(shadow=0.5)
        glfw.set_window_should_close(window.handle, True)
        assert not window.may_close()
        (tmp_path / "taken").unlink()
        glfw.set_window_should_close(window.handle, True)
        assert window.may_close()
    finally:
        window.close()
    assert len(leftovers(tmp_path / "taken" / "unsaved")) == 1
