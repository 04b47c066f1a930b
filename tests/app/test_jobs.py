"""Long work: how far it is, cancelling it, and going on past what fails."""

import threading
from types import SimpleNamespace

import av
import numpy as np
import pytest
from fake_relighter import LONG_S, FakeRelighter
from PIL import Image

from app.engine.batch import is_done, photos_in, relight_each, summary
from app.engine.film import write_film
from app.engine.jobs import Cancelled, JobControl, Jobs, JobStatus
from app.engine.snapshot import Message
from app.engine.turntable import turning, write_pictures
from app.ui.news import put_message_away
from app.ui.state import EditorState
from app.ui.viewport.progress_card import words
from app.window.outputs import _write_frame
from relight_core.errors import InputError
from relight_core.imaging.photo import Photo
from relight_core.imaging.write import write_image
from relight_core.lighting.rigs import load_rig
from relight_core.pipeline.edit import Edit


def test_what_a_job_has_saved_is_told_by_itself_and_what_failed_before_is_in_sight_again_after_it():
    all_wait, state = threading.Event(), EditorState()

    def say(text, is_error):
        state.snapshot = state.snapshot.telling(Message(len(state.snapshot.errors) + 1, text, is_error))

    def failing(control):
        assert all_wait.wait(LONG_S)
        raise InputError("1 could not be relit: b.jpg", "b.jpg: not an image")

    jobs = Jobs(say)
    jobs.start("Batch", failing)
    jobs.start("Export", lambda control: "Saved a-relit.png")
    all_wait.set()
    jobs.close()
    told = []
    while (message := state.message()) is not None:
        told.append((message.text, message.is_error))
        put_message_away(state)
    assert told == [("Saved a-relit.png", False), ("1 could not be relit: b.jpg\nb.jpg: not an image", True)]


def test_a_job_tells_how_far_it_is_and_what_became_of_it(jobs, said):
    middle, go_on = threading.Event(), threading.Event()

    def work(control):
        control.step(3, 12)
        middle.set()
        assert go_on.wait(LONG_S)
        return "Saved it"

    jobs.start("Film", work)
    assert middle.wait(LONG_S)
    assert jobs.is_busy()
    status = jobs.status()
    assert (status.name, status.done, status.total, status.share) == ("Film", 3, 12, 0.25)
    assert status.left_s >= 0
    assert status.waiting == 0
    assert words(status).startswith("Film   3 of 12, about ")
    go_on.set()
    jobs.close()
    assert said == [("Saved it", False)]
    assert jobs.status() is None


def test_of_a_job_of_unknown_length_nothing_is_done_yet():
    assert JobStatus("Film").share == 0.0


def held_until_a_step(begun, go_on, done, count):
    """Work that says that it has begun, and takes a step when it may go on."""

    def work(control):
        begun.set()
        assert go_on.wait(LONG_S)
        control.step(done, count)
        return "never"

    return work


def test_a_cancelled_job_stops_at_its_next_step_and_the_next_job_runs(jobs, said):
    begun, go_on, steps = threading.Event(), threading.Event(), []

    def work(control):
        begun.set()
        assert go_on.wait(LONG_S)
        for index in range(5):
            steps.append(index)
            control.step(index, 5)
        return "never"

    jobs.start("Film", work)
    jobs.start("Copy", lambda control: control.step(1, 1) or "Copied")
    assert begun.wait(LONG_S)
    jobs.cancel(jobs.status())
    assert "stopping" in words(jobs.status())
    assert jobs.status().waiting == 1
    go_on.set()
    jobs.close()
    assert steps == [0]
    assert said == [("Film: cancelled", False), ("Copied", False)]


def test_a_job_that_is_cancelled_stays_so_through_a_step_that_was_under_way(jobs):
    begun, go_on = threading.Event(), threading.Event()

    jobs.start("Film", held_until_a_step(begun, go_on, 3, 5))
    assert begun.wait(LONG_S)
    jobs.cancel(jobs.status())
    jobs.publish(JobStatus("Film", 2, 5, left_s=3.0))
    assert jobs.status() == JobStatus("Film", 2, 5, cancelling=True, number=1)
    go_on.set()


def test_a_cancel_that_comes_after_its_job_has_ended_leaves_the_next_one_alone(jobs, said):
    first, second, go_on = [], threading.Event(), threading.Event()

    def next_work(control):
        second.set()
        assert go_on.wait(LONG_S)
        control.step(1, 1)
        return "Copied"

    jobs.start("Copy", lambda control: first.append(jobs.status()) or "Saved it")
    jobs.start("Copy", next_work)
    assert second.wait(LONG_S)
    jobs.cancel(first[0])
    assert not jobs.status().cancelling
    go_on.set()
    jobs.close()
    assert said == [("Saved it", False), ("Copied", False)]


def test_jobs_run_where_their_thread_could_not_be_set_up(said):
    def fail():
        raise OSError("no priority")

    jobs = Jobs(lambda text, is_error: said.append((text, is_error)), on_start=fail)
    jobs.start("Copy", lambda control: "Copied")
    jobs.close()
    assert "no priority" in said[0][0]
    assert said[1:] == [("Copied", False)]
    assert not jobs.is_busy()


def test_a_job_that_could_not_be_queued_keeps_nobody_waiting(jobs):
    jobs.close()
    with pytest.raises(RuntimeError):
        jobs.start("Copy", lambda control: "Copied")
    assert not jobs.is_busy()


def test_a_job_that_was_taken_up_but_not_announced_as_they_closed_is_not_begun(jobs, said):
    begun = []
    jobs.close(cancel=True)
    jobs._run("Film", lambda control: begun.append(control) or "Saved it")
    assert begun == []
    assert said == [("Film: cancelled", False)]


def test_a_window_that_closes_stops_what_runs_at_its_next_step_and_begins_nothing_more(said):
    begun, go_on, told = threading.Event(), threading.Event(), threading.Event()
    jobs = Jobs(lambda text, is_error: said.append((text, is_error)), lambda: jobs.is_cancelled() and told.set())

    jobs.start("Film", held_until_a_step(begun, go_on, 1, 2))
    jobs.start("Copy", lambda control: "Copied")
    assert begun.wait(LONG_S)
    closing = threading.Thread(target=jobs.close, args=(True,))
    closing.start()
    was_told = told.wait(LONG_S)
    go_on.set()
    closing.join()
    assert was_told
    assert said == [("Film: cancelled", False)]


def test_jobs_that_fail_alike_are_counted_each_and_one_that_is_cancelled_is_not(said):
    all_wait = threading.Event()
    jobs = Jobs(lambda text, is_error: said.append((text, is_error)))

    def failing(control):
        assert all_wait.wait(LONG_S)
        raise InputError("x.png: full")

    def cancelled(control):
        raise Cancelled

    for work in (failing, failing, cancelled):
        jobs.start("Export", work)
    all_wait.set()
    jobs.close()
    assert said == [("x.png: full", True)] * 2 + [("Export: cancelled", False)]
    assert jobs.failures == 2


@pytest.mark.parametrize(
    ("error", "words_said"), [(InputError("x.png: full"), "x.png: full"), (OSError("no"), "A fault of ours")]
)
def test_a_failing_job_is_told_in_a_line(jobs, said, error, words_said):
    def work(control):
        raise error

    jobs.start("Film", work)
    jobs.close()
    ((text, is_error),) = said
    assert words_said in text
    assert is_error


def test_a_batch_goes_on_past_bad_photos_and_resumes(tmp_path):
    for name in ("a.jpg", "bad.jpg", "c.jpg"):
        (tmp_path / name).write_bytes(b"pixels")
    tasks = [(path, tmp_path / f"{path.stem}-relit.png") for path in photos_in(tmp_path)]
    worked = []

    def one(photo, output):
        worked.append(photo.stem)
        if photo.stem == "bad":
            raise InputError("no face")
        output.write_bytes(b"relit")

    outcomes = list(relight_each(tasks, one))
    assert [outcome.state for outcome in outcomes] == ["written", "failed", "written"]
    assert summary(outcomes) == "2 photos relit; 1 could not be relit: bad.jpg"
    again = list(relight_each(tasks, one, kept_if=is_done))
    assert [outcome.state for outcome in again] == ["kept", "failed", "kept"]
    assert worked == ["a", "bad", "c", "bad"]


def test_an_empty_output_is_not_done(tmp_path):
    (tmp_path / "a.jpg").write_bytes(b"pixels")
    (tmp_path / "a.png").touch()
    (outcome,) = relight_each([(tmp_path / "a.jpg", tmp_path / "a.png")], lambda *_: None, kept_if=is_done)
    assert outcome.state == "written"


def test_a_folder_without_photos_is_told(tmp_path):
    (tmp_path / "notes.txt").touch()
    (tmp_path / "album.jpg").mkdir()
    with pytest.raises(InputError, match="no photos"):
        photos_in(tmp_path)
    with pytest.raises(InputError, match="can't be read"):
        photos_in(tmp_path / "missing")


def test_what_was_exported_beside_a_photo_is_no_photo_of_the_folder(tmp_path):
    ours, theirs = ["a-relit.png", "a-relit-2.exr", "b.c-relit.jpg"], ["a.jpg", "b.c.png", "d-relit.jpg", "relit.jpg"]
    for name in (*ours, *theirs, "a-relit-new.png"):
        (tmp_path / name).write_bytes(b"pixels")
    assert [path.name for path in photos_in(tmp_path)] == sorted([*theirs, "a-relit-new.png"])


def test_what_was_exported_of_a_raw_photo_is_no_photo_either(tmp_path):
    for name in ("dsc_1.NEF", "dsc_1-relit.png", "dsc_2-relit.png"):
        (tmp_path / name).write_bytes(b"pixels")
    assert [path.name for path in photos_in(tmp_path)] == ["dsc_2-relit.png"]


class Steps:
    def __init__(self, cancel_at=None):
        self.done, self._cancel_at = [], cancel_at

    def step(self, done, total):
        self.done.append((done, total))
        if done == self._cancel_at:
            raise Cancelled


def test_what_is_left_takes_as_long_a_step_as_what_is_done_took(monkeypatch):
    clock, told = [100.0], []
    monkeypatch.setattr("app.engine.jobs.time", SimpleNamespace(monotonic=lambda: clock[0]))
    control = JobControl(SimpleNamespace(is_cancelled=lambda: False, publish=told.append), "Film")
    control.step(0, 12)
    clock[0] += 30.0
    control.step(3, 12)
    assert [status.left_s for status in told] == [None, 90.0]


def test_what_needed_no_work_says_nothing_of_how_long_the_rest_takes(monkeypatch):
    clock, told = [100.0], []
    monkeypatch.setattr("app.engine.jobs.time", SimpleNamespace(monotonic=lambda: clock[0]))
    control = JobControl(SimpleNamespace(is_cancelled=lambda: False, publish=told.append), "Batch")
    control.step(90, 100, 90)
    clock[0] += 20.0
    control.step(92, 100, 90)
    assert [(status.share, status.left_s) for status in told] == [(0.9, None), (0.92, 80.0)]


def frames(count, size=(31, 40)):
    relighter = FakeRelighter()
    relighter.set_portrait(Photo(np.full((*size, 3), 0.5, np.float32)))
    return relighter, turning(relighter, load_rig("split"), Edit(yaw_deg=10.0), None, count)


def test_the_turntable_goes_round_once_in_even_frames():
    relighter, turn = frames(4)
    pictures = list(turn)
    assert [edit.yaw_deg for edit in relighter.relights] == [10.0, 100.0, 190.0, 280.0]
    assert {picture.shape for picture in pictures} == {(30, 40, 3)}
    assert not np.array_equal(pictures[0], pictures[2])


def test_what_shows_through_is_dark_in_a_turntable():
    alpha = np.float32([[1.0, 0.25], [1.0, 0.25]])
    relit = SimpleNamespace(full=None, image=np.ones((2, 2, 3), np.float32), alpha=alpha)
    (frame,) = turning(SimpleNamespace(relight=lambda light, edit: relit), load_rig("split"), Edit(), None, 1)
    assert frame[:, 0].min() > 200
    assert frame[:, 1].max() < 150


def test_numbered_pictures_keep_their_transparency_and_their_size(tmp_path):
    alpha = np.float32([[1.0, 0.0, 128 / 255]] * 3)
    relit = SimpleNamespace(full=None, image=np.ones((3, 3, 3), np.float32), alpha=alpha)
    relighter = SimpleNamespace(relight=lambda light, edit: relit)
    turn = turning(relighter, load_rig("split"), Edit(), None, 2, for_film=False)
    write_pictures(tmp_path / "turn", turn, 2, Steps().step, _write_frame)
    picture = Image.open(tmp_path / "turn" / "0001.png")
    assert (picture.mode, picture.size) == ("RGBA", (3, 3))
    np.testing.assert_array_equal(np.asarray(picture)[0], [[255] * 4, [0] * 4, [255, 255, 255, 128]])


def test_a_film_has_every_frame_and_a_cancelled_one_leaves_nothing(tmp_path):
    control = Steps()
    write_film(tmp_path / "turn.mp4", frames(6)[1], 6, control.step)
    with av.open(str(tmp_path / "turn.mp4")) as film:
        assert len(list(film.decode(video=0))) == 6
    assert control.done[-1] == (6, 6)
    with pytest.raises(Cancelled):
        write_film(tmp_path / "half.mp4", frames(6)[1], 6, Steps(cancel_at=3).step)
    assert [path.name for path in tmp_path.iterdir()] == ["turn.mp4"]


def test_a_film_says_what_its_colours_mean_and_holds_those_of_its_frames(tmp_path):
    colours = [(200, 40, 30), (30, 160, 60), (20, 60, 220)]
    flat = (np.full((32, 32, 3), colour, np.uint8) for colour in colours)
    write_film(tmp_path / "flat.mp4", flat, 3, Steps().step)
    with av.open(str(tmp_path / "flat.mp4")) as film:
        coded = film.streams.video[0].codec_context
        bt709, srgb_curve, limited = 1, 13, 1
        assert (coded.name, coded.pix_fmt) == ("h264", "yuv420p")
        assert (coded.colorspace, coded.color_primaries, coded.color_trc) == (bt709, bt709, srgb_curve)
        assert coded.color_range == limited
        shown = [bt709_to_rgb(frame.to_ndarray()[[16, 36, 44], 8]) for frame in film.decode(video=0)]
    assert np.abs(np.array(shown) - colours).max() < 3.0


def bt709_to_rgb(yuv):
    y, u, v = (float(yuv[0]) - 16) / 219, (float(yuv[1]) - 128) / 224, (float(yuv[2]) - 128) / 224
    red, blue = y + 1.5748 * v, y + 1.8556 * u
    return 255 * red, 255 * (y - 0.2126 * red - 0.0722 * blue) / 0.7152, 255 * blue


def test_a_film_that_can_not_be_written_is_told_in_a_line(tmp_path):
    with pytest.raises(InputError, match="missing"):
        write_film(tmp_path / "missing" / "turn.mp4", frames(2)[1], 2, Steps().step)


def test_a_picture_sequence_is_a_new_folder_or_nothing(tmp_path):
    def write(path, frame):
        Image.fromarray(frame).save(path)

    write_pictures(tmp_path / "turn", frames(3)[1], 3, Steps().step, write)
    assert sorted(path.name for path in (tmp_path / "turn").iterdir()) == ["0001.png", "0002.png", "0003.png"]
    with pytest.raises(InputError, match="already"):
        write_pictures(tmp_path / "turn", frames(3)[1], 3, Steps().step, write)
    with pytest.raises(Cancelled):
        write_pictures(tmp_path / "half", frames(3)[1], 3, Steps(cancel_at=2).step, write)
    assert [path.name for path in tmp_path.iterdir()] == ["turn"]


def test_a_png_carries_its_notes(tmp_path):
    note = {"relightLight": "Rembrandt – à côté", "relightYawDeg": "-35.5"}
    write_image(tmp_path / "x.png", np.full((4, 4, 3), 0.5, np.float32), notes=note)
    with Image.open(tmp_path / "x.png") as picture:
        picture.load()
        assert {key: picture.text[key] for key in note} == note
