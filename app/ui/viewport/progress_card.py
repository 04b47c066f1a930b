"""Long work: how far it is, how long it takes, and Cancel; and the light that turns by itself."""

from __future__ import annotations

from imgui_bundle import imgui

from app.engine.exporting import EXPORT
from app.engine.jobs import JobStatus
from app.ui import theme
from app.ui.layout import Rect
from app.ui.state import EditorState

TURN_DEG_PER_S = 40.0
_LONGEST_STEP_S = 0.1
_WORTH_A_CARD_S = 0.5


def draw(state: EditorState, viewport: Rect) -> None:
    """The card at the foot of the viewport, while a job runs that takes its time."""
    job = state.job
    if job is None or not _takes_time(job):
        return
    em = imgui.get_font_size()
    width = min(26 * em, viewport.width - 2 * em)
    foot = imgui.ImVec2(viewport.x + viewport.width / 2, viewport.y + viewport.height - 3 * em)
    imgui.set_next_window_pos(foot, imgui.Cond_.always, imgui.ImVec2(0.5, 1.0))
    imgui.set_next_window_size(imgui.ImVec2(width, 0.0))
    imgui.push_style_color(imgui.Col_.plot_histogram, imgui.ImVec4(*theme.ACCENT))
    with theme.card("job", imgui.WindowFlags_.no_focus_on_appearing):
        imgui.text(words(job))
        if job.waiting:
            imgui.same_line()
            imgui.text_disabled(f"then {job.waiting} more")
        room = imgui.get_content_region_avail().x
        button = imgui.calc_text_size("Cancel").x + 1.6 * em
        imgui.progress_bar(job.share, imgui.ImVec2(room - button - imgui.get_style().item_spacing.x, 0.0), "")
        imgui.same_line()
        imgui.begin_disabled(job.cancelling)
        # A press that began on the card of the job before is none on this one's.
        if imgui.button(f"Cancel##{job.number}", imgui.ImVec2(button, 0.0)):
            state.cancel_wanted = job
        imgui.end_disabled()
    imgui.pop_style_color()


def _takes_time(job: JobStatus) -> bool:
    """An export is mostly done at once; a card that comes and goes would only startle."""
    return job.name != EXPORT or job.cancelling or (job.left_s is not None and job.left_s > _WORTH_A_CARD_S)


def words(job: JobStatus) -> str:
    """ "Turntable   34 of 120, about 12 s left"."""
    if job.cancelling:
        return f"{job.name}   stopping…"
    if not job.total:
        return f"{job.name}   getting ready…"
    left = "" if job.left_s is None else f", about {duration(job.left_s)} left"
    done = f"{100 * job.share:.0f} %" if job.name == EXPORT else f"{job.done} of {job.total}"
    return f"{job.name}   {done}{left}"


def duration(seconds: float) -> str:
    """ "12 s" or "3 min"."""
    return f"{max(1, round(seconds))} s" if seconds < 90 else f"{round(seconds / 60)} min"


def play(state: EditorState) -> None:
    """Turn the light a little further while it turns by itself."""
    if state.playing:
        state.turn(TURN_DEG_PER_S * min(imgui.get_io().delta_time, _LONGEST_STEP_S))
