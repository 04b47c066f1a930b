"""A job that is cancelled, or whose window closes, stops in its search for faces too, and not only at its next step."""

import threading
from pathlib import Path

from fake_relighter import LONG_S

from app.engine.batch import relight_each
from app.engine.jobs import Jobs
from relight_core.unwanted import stop_if_unwanted

PHOTOS = ["a.jpg", "b.jpg", "c.jpg"]


class Batch:
    """Work that searches photo after photo; at the second, `meanwhile` is done before it asks whether to go on."""

    def __init__(self, meanwhile=lambda: None):
        self.meanwhile, self.searched = meanwhile, []

    def __call__(self, control):
        tasks = [(Path(name), Path(name).with_suffix(".png")) for name in PHOTOS]
        return " ".join(outcome.state for outcome in relight_each(tasks, self._search))

    def _search(self, photo, output):
        self.searched.append(photo.name)
        if photo.name == "b.jpg":
            self.meanwhile()
        stop_if_unwanted()


def test_a_batch_that_is_cancelled_amid_a_search_ends_there_and_the_next_job_runs(jobs, said):
    batch, after = Batch(meanwhile=lambda: jobs.cancel(jobs.status())), Batch()
    jobs.start("Batch", batch)
    jobs.start("Batch", after)
    jobs.close()
    assert (batch.searched, after.searched) == (PHOTOS[:2], PHOTOS)
    assert said == [("Batch: cancelled", False), ("written written written", False)]
    assert jobs.failures == 0


def test_a_window_that_closes_waits_for_no_search_of_a_batch(said):
    cancelled = threading.Event()
    jobs = Jobs(lambda *line: said.append(line), lambda: jobs.is_cancelled() and cancelled.set())
    closing = threading.Thread(target=jobs.close, args=(True,))
    batch = Batch(meanwhile=lambda: closing.start() or cancelled.wait(LONG_S))
    jobs.start("Batch", batch)
    jobs.close()
    closing.join(LONG_S)
    assert batch.searched == PHOTOS[:2]
    assert said == [("Batch: cancelled", False)]
