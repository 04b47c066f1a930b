"""Boxes drawn by hand: what they change, and what they leave as it is."""

import time
from dataclasses import replace

import numpy as np
import pytest
import torch
from tiny_networks import tiny_bundle_with_person
from tiny_relighter import EDIT, NETWORK_STAGES, computed, some_light, some_photo

from relight_core.errors import InputError, NoFaceError
from relight_core.face.find import FaceBox
from relight_core.lighting.environment import Environment, network_light
from relight_core.lighting.roll import roll_light
from relight_core.lighting.summary import average_direction
from relight_core.networks.bundle import save_bundle
from relight_core.pipeline import face_in_photo, face_relighter, face_search, face_taken_apart, stages
from relight_core.pipeline.face_taken_apart import Workshop
from relight_core.pipeline.per_photo import choosing_faces
from relight_core.pipeline.quality import tier_of
from relight_core.pipeline.relighter import Relighter
from relight_core.pipeline.results.layers import CHANNEL_LAYERS, photo_layers

LARGE, SMALL, MOVED = FaceBox(24, 20, 72, 76), FaceBox(4, 4, 20, 20), FaceBox(80, 60, 104, 84)


@pytest.fixture
def photo():
    return some_photo()


@pytest.fixture
def delighted(monkeypatch):
    """The views that de-lighting saw."""
    seen, delight = [], Workshop.delight
    monkeypatch.setattr(Workshop, "delight", lambda shop, *args: seen.append(args[0]) or delight(shop, *args))
    return seen


def test_everyone_is_told_also_who_is_not_relit(relighter, photo):
    relighter.set_portrait(photo, 1)
    assert relighter.people == (LARGE, SMALL)
    relighter.set_portrait(photo, None, [MOVED])
    assert relighter.people == (MOVED,)


def test_only_the_face_that_moved_is_read_again(relighter, photo, delighted):
    relighter.set_portrait(photo, None, [LARGE, SMALL])
    relighter.relight(some_light(), EDIT)
    delighted.clear()
    relighter.set_portrait(photo, None, [LARGE, MOVED])
    assert len(delighted) in (1, 2), "framed, and once more if it leans"
    delighted.clear()
    relit = relighter.relight(some_light(), EDIT)
    assert len(delighted) == 2, "the view, and the small face from near"
    assert "delight" not in computed(relit), (
        "the first face is taken apart already; the light that both share is another"
    )
    assert computed(relit) >= {"other_faces", "matte", "detail", "paste"}


def test_one_face_alone_leaves_those_beside_it_what_is_theirs(relighter, photo):
    """Without the other box nothing is known of who is beside."""
    beside = FaceBox(76, 20, 108, 62)
    shares = []
    for face_index, boxes in ((None, [LARGE]), (0, [LARGE, beside])):
        relighter.set_portrait(photo, face_index, boxes)
        shares.append(relighter.relight(some_light(), EDIT).full.matte.nearby)
    width = shares[0].shape[1]
    alone, with_other = (share[:, round(0.75 * width) :].mean() for share in shares)
    assert alone > 0.1
    assert with_other < 0.8 * alone


def test_layers_hold_what_is_known_of_everyone(relighter, photo):
    """Whoever comes first."""
    beside, layers = FaceBox(76, 40, 108, 82), []
    for boxes in ([LARGE, beside], [beside, LARGE]):
        relighter.set_portrait(photo, None, boxes)
        relit = relighter.relight(some_light(), replace(EDIT, channels=None))
        layers.append(photo_layers(relit, CHANNEL_LAYERS))
    for name in {*CHANNEL_LAYERS} - {"foreign_shadow"}:
        for columns in (slice(20, 40), slice(72, 106)):
            one, other = (of_order[name][40:56, columns] for of_order in layers)
            assert one.any(), name
            np.testing.assert_allclose(one, other, atol=1e-4, err_msg=name)


def test_no_channel_of_others_is_made_before_it_is_asked_for(relighter, photo, monkeypatch):
    made = []
    monkeypatch.setattr(face_relighter, "light_channels", lambda *args: made.append(args) or {})
    relighter.set_portrait(photo, None, [LARGE, MOVED])
    assert not relighter.relight(some_light(), replace(EDIT, channels=())).channels_together()
    assert not made
    relit = relighter.relight(some_light(), replace(EDIT, channels=("albedo",)))
    assert len(made) == 1
    assert [set(one) for one in relit.channels_together()] == [{"albedo"}, {"albedo"}]
    assert len(made) == 2


def ends_of(monkeypatch, module, name):
    """When each call of a module's function has ended, from now on."""
    ends, function = [], getattr(module, name)

    def timed(*arguments, **how):
        result = function(*arguments, **how)
        ends.append(time.perf_counter())
        return result

    monkeypatch.setattr(module, name, timed)
    return ends


def test_the_networks_have_ended_when_those_of_the_last_face_have(relighter, photo, monkeypatch):
    ends = ends_of(monkeypatch, stages, "compose")
    relighter.set_portrait(photo, None, [LARGE, SMALL])
    relit = relighter.relight(some_light(), EDIT)
    assert len(ends) >= 2
    assert relit.networks_ended_s >= ends[-1]


@pytest.mark.usefixtures("small_and_seeing_faces")
def test_the_networks_have_ended_when_the_person_network_has(tmp_path, photo, monkeypatch):
    """Its wider look at the people comes last, for their outlines."""
    ends = ends_of(monkeypatch, face_taken_apart, "outline_person")
    save_bundle(tmp_path / "weights", tiny_bundle_with_person())
    relighter = Relighter(tmp_path / "weights")
    relighter.set_portrait(photo, None, [SMALL])
    relit = relighter.relight(some_light(), EDIT)
    assert len(ends) == 3
    assert relit.networks_ended_s >= ends[-1]


@pytest.mark.usefixtures("small_and_seeing_faces")
def test_who_is_not_relit_is_looked_at_by_the_person_network_alone(tmp_path, photo, delighted):
    save_bundle(tmp_path / "weights", tiny_bundle_with_person())
    relighter = Relighter(tmp_path / "weights")
    relighter.set_portrait(photo, 0, [LARGE, MOVED])
    delighted.clear()
    relighter.relight(some_light(), EDIT)
    assert len(delighted) == 1, "the view of the face that is relit"


def test_a_forgotten_stage_is_forgotten_of_every_face(relighter, photo, delighted):
    relighter.set_portrait(photo, None, [LARGE, MOVED])
    relighter.relight(some_light(), EDIT)
    seen = len(delighted)
    for stage in ("delight", "sliders", "other_faces"):
        relighter.forget(stage)
    relighter.relight(some_light(), EDIT)
    assert len(delighted) - seen == 3, "both views, and the small face from near"


def test_what_is_kept_of_faces_changes_no_picture(relighter, weights, photo):
    fresh = Relighter(weights)
    wishes = [(None, [LARGE, SMALL]), (None, [LARGE, MOVED]), (1, [LARGE, MOVED]), (None, [MOVED, LARGE]), (None, None)]
    for face_index, boxes in wishes:
        relighter.set_portrait(photo, face_index, boxes)
        fresh.set_portrait(replace(photo), face_index, boxes)
        one, other = (r.relight(some_light(), EDIT) for r in (relighter, fresh))
        np.testing.assert_array_equal(one.image, other.image)
        np.testing.assert_array_equal(one.channels["shadow"], other.channels["shadow"])
        assert one.faces == other.faces


def test_another_photo_keeps_nothing(relighter, photo):
    relighter.set_portrait(photo, None, [LARGE])
    relighter.relight(some_light(), EDIT)
    relighter.set_portrait(some_photo(7), None, [LARGE])
    assert computed(relighter.relight(some_light(), EDIT)) >= NETWORK_STAGES


def test_no_boxes_are_no_faces(relighter, photo):
    with pytest.raises(NoFaceError, match="no face"):
        relighter.set_portrait(photo, None, [])
    with pytest.raises(InputError, match="face number"):
        relighter.set_portrait(photo, 2, [LARGE, SMALL])
    with pytest.raises(InputError, match="box"):
        relighter.set_portrait(photo, 0, [LARGE, FaceBox(500, 10, 600, 90)])
    assert relighter.people == (LARGE, SMALL), "the portrait before stays"


def test_a_photo_without_faces_is_searched_once(relighter, monkeypatch, delighted):
    nobody = some_photo(3)
    monkeypatch.setattr(choosing_faces, "find_faces", lambda photo, *judge: [])
    monkeypatch.setattr(choosing_faces, "guess_faces", lambda photo: [SMALL])
    monkeypatch.setattr(face_search, "evidence_of_face", lambda labels, view, crop: 0)
    with pytest.raises(NoFaceError, match="no face found"):
        relighter.set_portrait(nobody)
    assert delighted
    relighter.set_portrait(nobody, None, [LARGE])
    delighted.clear()
    with pytest.raises(NoFaceError, match="no face found"):
        relighter.set_portrait(nobody)
    assert delighted == []


@pytest.mark.parametrize("roll_deg", [0.0, 38.0, -75.0])
def test_the_own_light_of_a_leaning_face_is_served_to_it_as_what_its_photo_is_explained_by(relighter, roll_deg):
    relighter.set_portrait(some_photo(), boxes=[FaceBox(24, 20, 72, 76, roll_deg)])
    own = relighter.estimated_light("live")
    face, tier = relighter._faces[0], tier_of("live")
    served = face._turned(network_light(own))
    torch.testing.assert_close(served, face._source_light(face.prepare(tier)), rtol=1e-4, atol=1e-5)


def test_the_light_that_a_leaning_face_is_explained_by_is_told_as_the_camera_sees_it(relighter, monkeypatch):
    lamp = np.full((16, 32, 3), 0.1, np.float32)
    lamp[6:8, 25:27] = 30.0
    seen = torch.from_numpy(roll_light(lamp, 38.0))[None]
    monkeypatch.setattr(face_in_photo, "explain_source_light", lambda *of_view: seen)
    relighter.set_portrait(some_photo(), boxes=[FaceBox(24, 20, 72, 76, 38.0)])
    found, meant = (
        average_direction(light) for light in (relighter.estimated_light("live"), Environment.from_radiance(lamp))
    )
    np.testing.assert_allclose(found, meant, atol=0.06)
