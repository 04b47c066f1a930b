"""What the panels read and write: one record, drawn from scratch every frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from app.document.document import Document, LightRef, PhotoRef
from app.document.history import History
from app.engine.exporting import ExportSettings
from app.engine.jobs import JobStatus
from app.engine.snapshot import Message, Snapshot
from app.engine.sources import LightSource, PhotoSource, Request
from app.ui.angles import wrap_degrees
from app.ui.asking import Asking, FileRequest
from app.ui.brush_edits import BrushTool
from app.ui.channels import PHOTO, RESULT, WHOLE_PHOTO, following
from app.ui.export_name import suggested_name
from app.ui.face_edits import FaceTool
from app.ui.falling_back import fall_back, give_up_what_is_on_its_way
from app.ui.fitted_work import fit_work
from app.ui.in_motion import edit_in_motion
from app.ui.layout import OpenGroups, Panels
from app.ui.light_edits import AimTool
from app.ui.light_list import wish_again
from app.ui.light_wish import LightWish, light_that_stays, note_light_wish
from app.ui.look import LookState
from app.ui.news import News
from app.ui.open_work import KeptWork, Opening, Undoing
from app.ui.photo_queue import PhotoQueue
from app.ui.photo_works import begin_work, note_left, wish_of
from app.ui.preview_size import longest_side_px
from app.ui.viewport.box_tools import Grab
from app.ui.viewport.view import View
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.lighting.light_edit import LightEdit
from relight_core.pipeline.auto_quality import QualityChoice
from relight_core.pipeline.edit import Edit


@dataclass
class EditorState:
    """The editor at one moment.

    docs/code.md explains how the fields on the work on a photo belong together.

    Attributes:
        photo, light: what the user wants to see; `snapshot` says what is in force.
        extra_lights: lights beyond the bundled ones, newest first.
        edit: the sliders.
        light_edit: what the user changed about the light.
        queue: the photos that were opened together.
        session_path: the file that the work was last saved to or opened from.
        kept: the document as that file has it, or as the photo was opened; None before there is a photo.
        asking: questions, messages and wishes between the window and the user.
        picking: what relight's own file dialog asks for, while it is open.
        quality: the tier that the user wants, or "auto" with its frame budget.
        plan_open: the list of effects with their reasons is unfolded.
        history: for undo and redo.
        history_seen: number of steps and the step in force when the list last scrolled to it.
        shown: name of the entry of CHANNELS that fills the viewport.
        before: the original photo is shown instead, while its key is held.
        view: zoom and pan.
        view_of: the photo that `view` belongs to.
        look: comparison, overlays and readings.
        panels: size, visibility and edge of each panel.
        panels_before: the panels as they were before Tab hid them all, until it brings them back.
        groups: which groups of the panels are open.
        export: how pictures are saved.
        job: the long-running job, if any.
        cancel_wanted: the job that the user wants cancelled; set for one frame.
        playing: the light rotates by itself.
        export_path: where the next export goes, relative to the photo's folder; its suffix follows `export.form` and
            the other way round.
        export_wanted: suffix of an export that the user asked for; set for one frame.
        quit_wanted: the window is to close, as by its own button; set for one frame.
        selected_box: index of the selected soft box, or -1.
        held: what the mouse holds on the panorama.
        hint_spent: something on the panorama was dragged since the mouse came to it, so no tooltip is needed.
        aim: the tool that places a lamp by a click on the face.
        news: which messages were put away, and how long the newest one that is not an error has been shown.
        typing: label of the slider or field whose value is being typed, if any.
        typing_began: that field still has to get the keyboard focus.
        typing_seen: that field was drawn in this frame.
        off_knob: distance from a slider's knob to the mouse when it took hold, which a drag keeps.
        hand_on_control: a slider or the panorama is being dragged.
        pointing_at_faces: the mouse is over the choice of faces, so the viewport numbers them.
        faces: the tool that corrects the boxes of the faces.
        brush: the tool that corrects the outline of the people.
        asked, asked_light: the edit and the light edit last submitted to the engine.
        snapshot: what the engine published last.
        light_panel: the light panel's rectangle (x0, y0, x1, y1) in the window, where a drop lends its light.
        opening, undoing: the session or the step of the history that was asked for and is not there yet.
        opened_queue: the queue when the open photo was asked for, or the first one that is still being read.
        works: the work on each photo of this run as it was left, by the photo's absolute path.
        work_on: absolute path of the open photo.
        photo_left: the wish for the open photo at the moment when another one was asked for.
        light_wish: a light that was asked for and is not there yet.
        started_afresh: absolute paths of the photos whose saved session was declined in this run.
        waiting: the open photo's own work, while it is shown with the light and the sliders of another.
    """

    photo: PhotoSource | None = None
    light: LightSource = field(default_factory=lambda: Document().light.source())
    extra_lights: list[LightSource] = field(default_factory=list)
    edit: Edit = field(default_factory=Edit)
    light_edit: LightEdit = field(default_factory=LightEdit)
    queue: PhotoQueue = field(default_factory=PhotoQueue)
    session_path: Path | None = None
    kept: Document | None = None
    asking: Asking = field(default_factory=Asking)
    picking: FileRequest | None = None
    quality: QualityChoice = field(default_factory=QualityChoice)
    plan_open: bool = False
    history: History = field(default_factory=History)
    history_seen: tuple[int, int] = (0, -1)
    shown: str = RESULT
    before: bool = False
    view: View = field(default_factory=View)
    view_of: Photo | None = None
    look: LookState = field(default_factory=LookState)
    panels: Panels = field(default_factory=Panels)
    panels_before: Panels | None = None
    groups: OpenGroups = field(default_factory=OpenGroups)
    export: ExportSettings = field(default_factory=ExportSettings)
    job: JobStatus | None = None
    cancel_wanted: JobStatus | None = None
    playing: bool = False
    export_path: str = ""
    export_wanted: str | None = None
    quit_wanted: bool = False
    selected_box: int = -1
    held: Grab | None = None
    hint_spent: bool = False
    aim: AimTool = field(default_factory=AimTool)
    news: News = field(default_factory=News)
    typing: str | None = None
    typing_began: bool = False
    typing_seen: bool = False
    off_knob: float = 0.0
    hand_on_control: bool = False
    pointing_at_faces: bool = False
    faces: FaceTool = field(default_factory=FaceTool)
    brush: BrushTool = field(default_factory=BrushTool)
    asked: Edit = field(default_factory=Edit)
    asked_light: LightEdit = field(default_factory=LightEdit)
    snapshot: Snapshot = field(default_factory=Snapshot)
    light_panel: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    opening: Opening | None = None
    undoing: Undoing | None = None
    opened_queue: PhotoQueue = field(default_factory=PhotoQueue)
    works: dict[Path, KeptWork] = field(default_factory=dict)
    work_on: Path | None = None
    photo_left: PhotoSource | None = None
    light_wish: LightWish | None = None
    started_afresh: set[Path] = field(default_factory=set)
    waiting: KeptWork | None = None
    _found: dict[Path, tuple[FaceBox, ...]] = field(default_factory=dict)

    def request(self) -> Request:
        """What the engine is to work toward: quick while something moves, finished when it rests."""
        edit = self.request_at_rest().edit
        quick = self._in_motion(edit)
        if self.is_moving:
            edit = edit_in_motion(edit, quick, self.asked if self.light_edit == self.asked_light else None)
        self.asked, self.asked_light = edit, self.light_edit
        return replace(self._request_of(edit), in_motion=None if edit.quality == quick.quality else quick)

    def _in_motion(self, edit: Edit) -> Edit:
        """What is asked for while the hand moves, where this is at rest."""
        tier = {"quality": self.quality.moving(self.snapshot.tier_costs), "surface_of": self.quality.surface_of()}
        return replace(edit, **tier, channels=following(self.shown))

    @property
    def is_moving(self) -> bool:
        """Whether the hand or the rotation changes the picture, so that speed counts more than finish."""
        return self.hand_on_control or self.playing

    def request_at_rest(self) -> Request:
        """What the engine is to work toward once the hand rests."""
        edit = replace(self.edit, quality=self.quality.at_rest(), exposure_ev=0.0)
        return self._request_of(edit)

    def document(self) -> Document:
        """What undo and sessions keep of all this."""
        photo, path = None, self.photo.path if self.photo else None
        if path:
            wish = self.photo.on(self.snapshot.opened.photo) if self.is_at_work() else self.photo
            photo = PhotoRef.of(wish, path, self._found.get(path, ()))
        light = LightRef.of(self.light)
        edit = replace(self.edit, quality="final", channels=None)
        return Document(photo, light, self.light_edit, edit, self.quality.wish)

    def remember(self, now_s: float) -> None:
        """Let the history see what was changed; once a frame."""
        is_in_force = self.is_in_force()
        if is_in_force:
            self.undoing = None
        self.history.observe(self.document(), not self.hand_on_control and is_in_force, now_s, self.playing)

    def restore(self, document: Document | None) -> None:
        """Put a step of the history back, as undo does; None changes nothing.

        Where its photo or its light turns out to be gone, everything comes back as it was before. A light that plays
        and is turned back by it turns no further; by any other step it plays on from where it is.
        """
        if document is None:
            return
        self.asking.level = None
        self.playing = self.playing and not self.history.has_turned
        step = self.undoing.step if self.undoing else self.history.left
        note_left(self)
        self.put_step_back(document)
        self.opening, self.undoing = None, Undoing(step, self.photo, self.light)

    def put_step_back(self, document: Document) -> None:
        """As `put_back`, but for the angle of a light that plays, which is no part of any step yet."""
        yaw_deg = (self if self.playing else document).edit.yaw_deg
        self.put_back(document)
        self.change(yaw_deg=yaw_deg)

    def put_back(self, document: Document) -> None:
        """Set everything a document keeps; without a photo it leaves the photo as it is."""
        self.edit = replace(document.edit, quality=self.edit.quality)
        self.take_light_edit(document.light_edit)
        self.quality = replace(self.quality, wish=document.quality)
        if not document.light.source().same_as(self.light):
            self.light = self._known(document.light.source())
        if document.photo is not None and document.photo != self.document().photo:
            opened = self.snapshot.opened
            is_open = opened is not None and opened.source.path == document.photo.path
            self.photo = document.photo.wish(opened.photo if is_open else None)
            self.queue = self.queue.showing(document.photo.path)

    def change(self, **fields) -> None:
        """Set fields of the edit."""
        self.edit = replace(self.edit, **fields)

    def take_light_edit(self, edit: LightEdit) -> None:
        """Put another light edit in the place of this one; the soft box that is selected stays so, if it is there."""
        before, index = self.light_edit.boxes, self.selected_box
        if len(before) != len(edit.boxes) and 0 <= index < len(before):
            index = edit.boxes.index(before[index]) if before[index] in edit.boxes else -1
        self.light_edit, self.selected_box = edit, index

    def make_room_for_a_tool(self) -> None:
        """Put away whatever follows the mouse over the picture, and show the whole photo, over which tools lie."""
        self.aim.target, self.playing = "", False
        self.faces, self.brush = FaceTool(), self.brush.put_away()
        if self.shown not in WHOLE_PHOTO:
            self.shown = RESULT

    def reset(self) -> None:
        """Put every slider and the light back, which then stays there."""
        self.edit, self.asking.level, self.playing = Edit(), None, False
        self.take_light_edit(self.light.opening_edit)

    def turn(self, degrees: float) -> None:
        """Turn the light; the angle stays within (-180, 180]."""
        self.change(yaw_deg=wrap_degrees(self.edit.yaw_deg + degrees))

    def forget_light(self, light: LightSource) -> None:
        """Take a file's light off the list, unless it is the one in use."""
        if not light.same_as(self.light):
            self.extra_lights = [known for known in self.extra_lights if not known.same_as(light)]

    def open_photo(self, path: Path) -> None:
        """Ask for another portrait; one that was open before comes back with its faces as they were."""
        self._wish_for(wish_of(self, path))

    def open_photos(self, paths: Sequence[Path]) -> None:
        """Ask for the first of several portraits; the others wait in the queue."""
        self.open_photo(paths[0])
        self.queue = PhotoQueue(tuple(paths))

    def step_photo(self, by: int) -> None:
        """Ask for a photo further on in the queue."""
        queue = self.queue.step(by)
        if queue is not None:
            self.open_photo(queue.current)
            self.queue = queue

    def open_session(self, document: Document, path: Path | None) -> None:
        """Ask for work that was saved; everything comes back as it is now if its photo can't be opened.

        Args:
            path: its file, where it will be saved again; None for work that no session file holds.
        """
        give_up_what_is_on_its_way(self)
        note_left(self)
        before = self.document()
        self.photo = document.photo.wish()
        self.opening = Opening(self.photo, path, document, before)
        self.put_back(document)

    def use_light(self, light: LightRef, light_edit: LightEdit, yaw_deg: float) -> None:
        """Ask for a light with everything that was changed about it."""
        before = light_that_stays(self)
        self.open_light(light.source())
        self.take_light_edit(light_edit)
        self.change(yaw_deg=yaw_deg)
        note_light_wish(self, before)

    def is_unsaved(self) -> bool:
        """Whether there is work that no session file holds."""
        return self.kept is not None and self.photo is not None and self.document() != self.kept

    def is_at_work(self) -> bool:
        """Whether the photo that is wanted is the one that is open, so that what is set is work on it."""
        opened = self.snapshot.opened
        return opened is not None and self.photo is not None and opened.shows(self.photo)

    def is_in_force(self) -> bool:
        """Whether the photo and the light that were asked for are there, so that neither can still be refused.

        Light that only waits for a face is not refused.
        """
        snapshot = self.snapshot
        photo_is = self.photo is None or self.is_at_work()
        light_is = snapshot.light is not None and self.light.same_as(snapshot.light.source)
        return photo_is and (light_is or (self.light is snapshot.awaited and not snapshot.faces))

    def choose_face(self, index: int | None) -> None:
        """Ask for one face of the open photo, or for all of them."""
        if (opened := self.snapshot.opened) is None:
            return
        if self.is_at_work():
            self.photo = replace(self.photo.on(opened.photo), face_index=index)
        else:
            self._wish_for(replace((self.photo_left or opened.source).on(opened.photo), face_index=index))
            self.queue = self.queue.showing(opened.source.path)

    def choose_light(self, light: LightSource) -> None:
        """Ask for another light, around the user's own soft boxes; one in the list is the one in the list."""
        if not light.same_as(self.light):
            before = light_that_stays(self)
            self.light = self._known(light)
            self.take_light_edit(light.opened_around(self.light_edit))
            note_light_wish(self, before)

    def open_light(self, light: LightSource) -> None:
        """Ask for the light in a file as the file is now; one that is in use keeps what was changed about it."""
        before = light_that_stays(self)
        self.choose_light(light)
        self.light = self._known(light, afresh=True)
        note_light_wish(self, before)

    def accept(self, snapshot: Snapshot) -> None:
        """Take over what the engine published; wishes it refused fall back to what is in force."""
        opened_before = self.snapshot.opened
        self.snapshot = snapshot
        fall_back(self)
        if snapshot.light and snapshot.light.source.is_from_file:
            self._remember(snapshot.light.source)
        if snapshot.opened and (opened_before is None or snapshot.opened.photo is not opened_before.photo):
            self.export_path = suggested_name(self)
            self.shown = RESULT
            self.aim = AimTool(refusal=self.aim.refusal)
            self.photo_left = None
            fit_work(self)
            self.faces = FaceTool(not snapshot.faces, self.photo if self.is_at_work() else snapshot.opened.source)
            self.brush = BrushTool(radius_em=self.brush.radius_em)
            if snapshot.opened.source.path and self.is_at_work():
                self.queue = self.queue.showing(snapshot.opened.source.path)
            self.opened_queue = self.queue
            begin_work(self)
        if snapshot.opened and snapshot.opened.source.path and snapshot.opened.source.boxes is None:
            self._found[snapshot.opened.source.path] = snapshot.faces

    def message(self) -> Message | None:
        """The line to show, as of `News.in_sight`."""
        return self.news.in_sight(self.snapshot)

    def shown_name(self) -> str:
        """Which picture fills the viewport now; the photo as long as there is no result."""
        if self.before:
            return PHOTO
        picture = self.snapshot.picture_in_sight
        if self.shown == PHOTO or picture is None:
            return PHOTO
        return self.shown if self.shown == RESULT or self.shown in picture.channels else RESULT

    def _wish_for(self, photo: PhotoSource) -> None:
        give_up_what_is_on_its_way(self)
        note_left(self)
        self.photo = photo

    def _request_of(self, edit: Edit) -> Request:
        size_px = longest_side_px(self.is_at_work(), self.view, edit)
        return Request(self.photo, self.light, edit, self.light_edit, size_px, outlined=self.brush.is_open)

    def _known(self, light: LightSource, afresh: bool = False) -> LightSource:
        wish, self.extra_lights = wish_again(light, self.extra_lights, self.snapshot.refused, afresh)
        return wish

    def _remember(self, light: LightSource) -> None:
        if not any(known.same_as(light) for known in self.extra_lights):
            self.extra_lights.insert(0, light)
