"""What the engine keeps between steps, and what it lets go: lights, channels, portraits, costs, refusals."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fake_relighter import LONG_S, FakeRelighter, FakeStage, answered, photos_read

from app.engine import tier_meter
from app.engine.calibration_file import write_costs
from app.engine.engine import Engine
from app.engine.sources import LightSource, PhotoSource, Request
from relight_core.errors import InputError
from relight_core.face.find import FaceBox
from relight_core.imaging.photo import Photo
from relight_core.imaging.write import write_image
from relight_core.lighting.light_edit import LightEdit
from relight_core.pipeline.auto_quality import TierCost
from relight_core.pipeline.edit import Edit
from relight_core.pipeline.per_photo.brush import BrushStroke

SPLIT = LightSource("rig", "split")
BOX, OTHER, OUTSIDE = FaceBox(4, 4, 20, 20), FaceBox(10, 2, 22, 14), FaceBox(-40, 0, -8, 30)


class Sparing(FakeRelighter):
    """Computes only the channels that are looked at."""

    def _channels(self, edit, light):
        return {name: image for name, image in super()._channels(edit, light).items() if edit.looks_at(name)}


class Timed(FakeRelighter):
    """Every picture takes 777 ms."""

    def relight(self, *arguments, **named):
        stages = {"irradiance": FakeStage(0.0), "specular_shadow": FakeStage(0.0), "compose": FakeStage(777.0)}
        return replace(super().relight(*arguments, **named), stages=stages)


class Interrupted(FakeRelighter):
    """Something else is wanted while it makes its first draft; what it makes shows which face it is of."""

    wanted = None

    def relight(self, environment, edit, longest_side_px=None, *, for_shader=False):
        if edit.quality == "draft" and self.wanted is not None:
            engine, request = self.wanted
            self.wanted = None
            engine.submit(request)
        relit = super().relight(environment, edit, longest_side_px, for_shader=for_shader)
        return replace(relit, image=relit.image * np.float32(1 / self.people[0].x1))


def a_photo(value=0.5, size=(24, 32)):
    return Photo(np.full((*size, 3), value, np.float32))


@pytest.fixture
def engine(relighter):
    engine = Engine(lambda: relighter)
    yield engine
    engine.close()


@pytest.fixture
def started():
    """Starts an engine on a relighter, and closes it in the end."""
    engines = []

    def start(relighter, **named):
        engines.append(Engine(lambda: relighter, **named))
        return engines[-1]

    yield start
    for engine in engines:
        engine.close()


@pytest.fixture
def friend(tmp_path):
    write_image(tmp_path / "friend.png", np.broadcast_to(np.float32([0.8, 0.2, 0.2]), (20, 20, 3)))
    return LightSource("portrait", str(tmp_path / "friend.png"))


def sky(path, value):
    radiance = np.full((16, 32, 3), 0.1, np.float32)
    radiance[2:5, 20:24] = value
    write_image(path, radiance)
    return LightSource("panorama", str(path))


def test_the_first_photo_and_its_light_are_there_to_look_at_while_the_networks_load(relighter):
    seen = []
    engine = Engine(lambda: seen.append(engine.snapshot()) or relighter)
    source = PhotoSource(a_photo())
    opened = answered(engine, Request(source, SPLIT, Edit())).opened
    engine.close()
    assert seen[0].coming.source is source
    assert seen[0].light.source is SPLIT
    assert opened.screen is seen[0].coming.screen, "and not uploaded again"


def test_a_first_photo_that_is_refused_is_no_longer_coming(engine):
    bad = PhotoSource(a_photo(), None, (OUTSIDE,))
    snapshot = answered(engine, Request(bad, SPLIT, Edit()))
    assert (snapshot.opened, snapshot.coming) == (None, None)


def test_a_photo_without_a_face_stays_open_while_a_light_is_borrowed(engine, friend):
    nobody = PhotoSource(a_photo(0.0))
    snapshot = answered(engine, Request(nobody, friend, Edit()))
    assert snapshot.light.source is friend
    assert snapshot.opened.source is nobody
    assert (snapshot.message, snapshot.refused) == (None, frozenset())


def test_a_light_can_be_borrowed_before_a_photo_is_opened(engine, friend):
    assert answered(engine, Request(None, friend, Edit())).light.source is friend


def test_what_is_changed_about_own_light_before_there_is_a_photo_changes_none_in_its_place(engine):
    answered(engine, Request(None, SPLIT, Edit()))
    waiting = answered(engine, Request(None, LightSource("own"), Edit(), LightEdit(metered=True)))
    assert waiting.light.source is SPLIT
    assert waiting.light.edit == LightEdit()


def test_the_portrait_that_comes_back_after_a_loan_has_its_faces_and_its_outline(engine, relighter, friend):
    strokes = (BrushStroke(((3.0, 4.0),), 2.0, True),)
    source = PhotoSource(a_photo(), 1, (BOX, OTHER), strokes)
    answered(engine, Request(source, SPLIT, Edit()))
    lent_for = len(relighter.portraits)
    snapshot = answered(engine, Request(source, friend, Edit()))
    assert snapshot.picture.light.source is friend
    assert len(relighter.portraits) == lent_for + 2
    assert relighter.portraits[-1] == relighter.portraits[lent_for - 1] == (source.place, 1, (BOX, OTHER))
    assert relighter.strokes == strokes


def test_lights_from_files_stay_open_for_going_back_and_forth(engine, tmp_path):
    source = PhotoSource(a_photo())
    lights = [sky(tmp_path / f"{index}.exr", 5.0 + index) for index in range(4)]
    seen = [answered(engine, Request(source, light, Edit(), light.opening_edit)).light for light in lights]
    for path in tmp_path.iterdir():
        path.unlink()
    for light, before in zip(lights[::-1], seen[::-1], strict=True):
        after = answered(engine, Request(source, light, Edit(), light.opening_edit))
        gone = light is lights[0]
        assert (light in after.refused) == gone, "three of them do"
        assert gone or after.light.environment is before.environment


def test_the_lamps_of_a_bundled_light_are_known(engine):
    light = answered(engine, Request(PhotoSource(a_photo()), SPLIT, Edit())).light
    assert len(light.lamps) >= 1
    assert all(lamp.name for lamp in light.lamps)


@pytest.mark.parametrize(
    ("quality", "change", "is_draft"),
    [("live", {"warmth": 0.5}, True), ("final", {"warmth": 0.5}, False), ("live", {"level_ev": 1.0}, False)],
)
def test_while_the_hand_moves_a_light_of_another_shape_is_drawn_coarsely(engine, quality, change, is_draft):
    wish = Request(PhotoSource(a_photo()), SPLIT, Edit(quality=quality, channels=()), LightEdit(**change))
    assert answered(engine, wish).light.is_draft == is_draft


def test_a_light_that_was_drawn_coarsely_and_can_not_be_drawn_finely_is_tried_once(engine, monkeypatch):
    source, warm, tries = PhotoSource(a_photo()), LightEdit(warmth=0.5), []
    answered(engine, Request(source, SPLIT, Edit(quality="live", channels=()), warm))

    def fail(*_):
        tries.append(1)
        raise MemoryError("no room")

    monkeypatch.setattr("app.engine.desk.edit_light", fail)
    engine.submit(Request(source, SPLIT, Edit(quality="live"), warm))
    assert engine.wait_until_idle(LONG_S)
    assert len(tries) == 1


def test_a_large_photo_s_picture_is_made_anew_as_large_as_it_is_looked_at(engine, relighter, monkeypatch):
    monkeypatch.setattr("app.engine.desk._SMALL_PHOTO_PX", 100)
    source = PhotoSource(a_photo())
    for side_px in (16, None, 16):
        picture = answered(engine, Request(source, SPLIT, Edit(), longest_side_px=side_px)).picture
        assert (picture.longest_side_px, relighter.sides_px[-1]) == (side_px, side_px)
    assert len(relighter.sides_px) == 3


def test_the_lamps_of_a_panorama_are_known(engine, tmp_path):
    radiance = np.full((64, 128, 3), 0.1, np.float32)
    radiance[16:18, 90:92] = 500.0
    write_image(tmp_path / "sun.exr", radiance)
    sun = LightSource("panorama", str(tmp_path / "sun.exr"))
    assert len(answered(engine, Request(PhotoSource(a_photo()), sun, Edit())).light.lamps) == 1


def test_own_light_that_can_not_be_told_is_tried_once_for_each_photo(engine, relighter, monkeypatch):
    tries = []

    def fail(quality):
        tries.append(quality)
        raise MemoryError("no room")

    monkeypatch.setattr(relighter, "estimated_light", fail)
    for count in (1, 2):
        engine.submit(Request(PhotoSource(a_photo()), SPLIT, Edit()))
        assert engine.wait_until_idle(LONG_S)
        assert len(tries) == count
    monkeypatch.undo()
    assert answered(engine, Request(PhotoSource(a_photo()), SPLIT, Edit())).own_light is not None


def test_own_light_that_is_asked_for_at_once_is_estimated_once(engine, relighter):
    snapshot = answered(engine, Request(PhotoSource(a_photo()), LightSource("own"), Edit(exposure_ev=1.0)))
    assert snapshot.own_light is snapshot.light
    assert relighter.estimated_at == ["final"]
    assert [edit.exposure_ev for edit in relighter.relights] == [0.0], "which is the shader's business"
    assert snapshot.picture.edit.exposure_ev == 0.0


def test_channels_that_are_not_looked_at_stay_as_they_were_of_the_same_portrait_alone(started):
    engine, source = started(Sparing()), PhotoSource(a_photo())
    every = answered(engine, Request(source, SPLIT, Edit())).picture.channels
    moving = answered(engine, Request(source, SPLIT, Edit(channels=("shadow",), shadow=0.1))).picture.channels
    assert set(moving) == set(every)
    assert moving["albedo"] is every["albedo"]
    assert moving["shadow"].mean() < every["shadow"].mean()
    other = answered(engine, Request(PhotoSource(a_photo(0.3)), SPLIT, Edit(channels=("shadow",)))).picture
    assert set(other.channels) == {"shadow"}


def test_a_channel_that_is_gone_does_not_stay_once_all_are_asked_for(engine, relighter):
    relighter.in_foreign_shadow, source = True, PhotoSource(a_photo())
    assert "foreign_shadow" in answered(engine, Request(source, SPLIT, Edit())).picture.channels
    without = Edit(forced_off=frozenset({"foreign_shadow"}))
    assert "foreign_shadow" not in answered(engine, Request(source, SPLIT, without)).picture.channels


def test_what_could_not_be_relit_is_tried_again_when_it_is_asked_for_again(engine, relighter):
    source = PhotoSource(a_photo())
    relighter.fail_with = MemoryError("no room")
    assert answered(engine, Request(source, SPLIT, Edit(yaw_deg=5.0))).picture is None
    relighter.fail_with = None
    for yaw_deg in (6.0, 5.0):
        assert answered(engine, Request(source, SPLIT, Edit(yaw_deg=yaw_deg))).picture.edit.yaw_deg == yaw_deg


def test_what_a_correction_was_refused_for_is_not_asked_again_while_its_photo_is_open(engine):
    first = PhotoSource(a_photo())
    answered(engine, Request(first, SPLIT, Edit()))
    refused = PhotoSource(first.place, None, (OUTSIDE,))
    answered(engine, Request(refused, SPLIT, Edit()))
    after = answered(engine, Request(PhotoSource(first.place, None, (BOX,)), SPLIT, Edit()))
    assert refused in after.refused


def test_a_photo_that_was_read_before_the_networks_could_not_be_loaded_is_not_kept(monkeypatch):
    def fail():
        raise InputError("relight.safetensors: damaged; fetch it again")

    still_there = photos_read(monkeypatch, a_photo)
    engine = Engine(fail)
    source = PhotoSource(Path("a.png"))
    assert source in answered(engine, Request(source, SPLIT, Edit())).refused
    assert still_there() == [False]
    engine.close()


@pytest.fixture
def costs_path(tmp_path, monkeypatch):
    monkeypatch.setattr(tier_meter, "machine_key", lambda: "this machine")
    return tmp_path / "tiers.json"


def test_what_the_tiers_cost_is_measured_once_and_known_from_then_on(started, costs_path):
    source = PhotoSource(a_photo())
    measured = answered(started(FakeRelighter(), calibration_path=costs_path), Request(source, SPLIT, Edit()))
    assert set(measured.tier_costs) == {"draft", "live", "final"}
    later = FakeRelighter()
    known = answered(started(later, calibration_path=costs_path), Request(source, SPLIT, Edit()))
    assert known.tier_costs == measured.tier_costs
    assert len(later.relights) == 1


def test_in_the_dark_no_tier_is_measured(started, costs_path, tmp_path):
    write_image(tmp_path / "dark.exr", np.zeros((8, 16, 3), np.float32))
    dark = LightSource("panorama", str(tmp_path / "dark.exr"))
    engine, source = started(FakeRelighter(), calibration_path=costs_path), PhotoSource(a_photo())
    assert answered(engine, Request(source, dark, Edit())).tier_costs == {}
    assert set(answered(engine, Request(source, SPLIT, Edit())).tier_costs) == {"draft", "live", "final"}


LARGER, PHOTO = a_photo(0.25, (40, 36)), a_photo()


@pytest.mark.parametrize(
    ("photo", "light"),
    [
        (PhotoSource(LARGER), SPLIT),
        (PhotoSource(PHOTO, None, (BOX,)), SPLIT),
        (PhotoSource(PHOTO), LightSource("rig", "ring")),
    ],
    ids=["another photo", "another face", "another light"],
)
def test_tiers_are_compared_by_pictures_of_the_same(started, costs_path, photo, light):
    relighter = Interrupted()
    engine = started(relighter, calibration_path=costs_path)
    relighter.wanted = engine, Request(photo, light, Edit())
    measured = answered(engine, Request(PhotoSource(PHOTO), SPLIT, Edit()))
    assert measured.light.source is light
    assert measured.message is None
    assert {name: cost.error for name, cost in measured.tier_costs.items()} == {"draft": 0, "live": 0, "final": 0}


def test_what_a_photo_s_pictures_cost_is_forgotten_with_the_photo(started, costs_path):
    kept = {name: TierCost(5.0, 0.01) for name in ("draft", "live", "final")}
    write_costs(costs_path, "this machine", kept)
    engine, source = started(Timed(), calibration_path=costs_path), PhotoSource(a_photo())
    for turn in range(6):
        last = answered(engine, Request(source, SPLIT, Edit(yaw_deg=9.0 * turn)))
    assert last.tier_costs == kept | {"live": TierCost(777.0, 0.01)}
    assert answered(engine, Request(PhotoSource(a_photo()), SPLIT, Edit())).tier_costs == kept
