"""Two looks at one surface: where they agree nothing changes, where they don't the nearer one is believed of faces."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from tiny_relighter import EDIT, some_light, some_photo, states

from relight_core.face.crop import Crop
from relight_core.face.find import FaceBox
from relight_core.imaging.view_transform import apply_view
from relight_core.pipeline import quality
from relight_core.pipeline.per_photo.nearer_look import (
    nearer_view,
    with_nearer_change,
    with_nearer_effects,
    with_nearer_look,
)
from relight_core.pipeline.per_photo.portrait import Portrait
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.relighter import Relighter
from relight_core.pipeline.results.channels import ViewChange
from relight_core.pipeline.stages import Surface

SIZE = 64
VIEW = Crop(100.0, 90.0, 160.0)
NEARER = Crop(110.0, 80.0, 80.0)
FACE = (slice(24, 32), slice(36, 44))
"""Rows and columns of the view that lie in the middle of the nearer one."""


def surface_seen_in(view, albedo=0.5, lift=0.0):
    """A slope of 0.3 in both directions of the photo, skin everywhere."""
    places = (np.arange(SIZE) + 0.5) / SIZE * view.side
    x, y = np.meshgrid(view.centre_x - view.side / 2 + places, view.centre_y - view.side / 2 + places)
    height_px = 0.3 * (x + y) + lift
    parsing = torch.zeros(1, 14, SIZE, SIZE)
    parsing[:, 1] = 1
    return Surface(
        photo=torch.full((1, 3, SIZE, SIZE), 0.4),
        albedo=torch.full((1, 3, SIZE, SIZE), albedo),
        normal=torch.tensor([0.6, 0.0, 0.8])[None, :, None, None].expand(1, 3, SIZE, SIZE).contiguous(),
        relief=torch.from_numpy(height_px / (view.side / 2)).float()[None, None],
        parsing=parsing,
        person=torch.ones(1, 1, SIZE, SIZE),
        source_light=torch.ones(1, 16, 32, 3),
    )


def test_looks_that_agree_change_nothing():
    """A nearer look's relief has no level of its own, and counts in half-widths of another view."""
    wide = surface_seen_in(VIEW)
    both = with_nearer_look(wide, surface_seen_in(NEARER, lift=17.0), VIEW, NEARER)
    for name in ("albedo", "normal", "relief", "parsing", "source_light"):
        torch.testing.assert_close(getattr(both, name), getattr(wide, name), atol=2e-3, rtol=0)


def test_a_face_is_as_the_nearer_look_has_it_and_the_rest_as_the_view():
    wide, near = surface_seen_in(VIEW), surface_seen_in(NEARER)
    near = replace(near, normal=torch.tensor([0.0, 0.6, 0.8])[None, :, None, None].expand(1, 3, SIZE, SIZE))
    normal = with_nearer_look(wide, near, VIEW, NEARER).normal
    rows, columns = FACE
    torch.testing.assert_close(normal[..., rows, columns], near.normal[..., :8, :8])
    torch.testing.assert_close(normal[..., 48:, :], wide.normal[..., 48:, :])
    torch.testing.assert_close(normal.norm(dim=1), torch.ones(1, SIZE, SIZE))


def test_who_is_person_is_as_the_nearer_look_has_it():
    background, skin = 0, 1
    wide = surface_seen_in(VIEW)
    wide.parsing[:, background], wide.parsing[:, skin] = 1, 0
    both = with_nearer_look(wide, surface_seen_in(NEARER), VIEW, NEARER)
    for image in (both.parsing[0, skin], both.person[0, 0]):
        np.testing.assert_allclose(image[FACE], 1, atol=1e-3)
        np.testing.assert_allclose(image[48:], 0, atol=1e-3)


def test_the_whole_albedo_takes_the_level_of_the_nearer_look():
    albedo = with_nearer_look(surface_seen_in(VIEW, 0.5), surface_seen_in(NEARER, 0.4), VIEW, NEARER).albedo
    torch.testing.assert_close(albedo, torch.full_like(albedo, 0.4), atol=1e-4, rtol=0)


def test_a_view_without_a_person_stays_finite():
    wide = replace(surface_seen_in(VIEW), person=torch.zeros(1, 1, SIZE, SIZE))
    both = with_nearer_look(wide, surface_seen_in(NEARER), VIEW, NEARER)
    assert both.albedo.isfinite().all()
    assert both.relief.isfinite().all()


@pytest.mark.parametrize(("side", "looks"), [(100.0, False), (120.0, False), (150.0, True)])
def test_only_a_small_face_is_looked_at_again(side, looks):
    box, crop = FaceBox(60, 50, 140, 130), Crop(100.0, 90.0, 100.0)
    nearer = nearer_view(Portrait(some_photo(), box, box, crop, Crop(100.0, 90.0, side)))
    assert (nearer is not None) == looks


def slope_seen_in(view):
    places = (np.arange(SIZE) + 0.5) / SIZE * view.side
    x, y = np.meshgrid(view.centre_x - view.side / 2 + places, view.centre_y - view.side / 2 + places)
    return np.repeat((0.01 * x + 0.02 * y)[..., None], 3, -1).astype(np.float32)


def test_changes_and_effects_of_two_views_lie_on_each_other():
    wide, near = slope_seen_in(VIEW), slope_seen_in(NEARER)
    change = with_nearer_change(ViewChange(wide, 2 * wide, 1.0), ViewChange(near, 2 * near, 1.0), VIEW, NEARER)
    np.testing.assert_allclose(change.gain, wide, atol=2e-3)
    np.testing.assert_allclose(change.offset, 2 * wide, atol=4e-3)
    both = ({"specular": part[..., 0], "shadow": 3 * part[..., 0]} for part in (wide, near))
    effects = with_nearer_effects(*both, VIEW, NEARER)
    np.testing.assert_allclose(effects["specular"], wide[..., 0], atol=2e-3)
    np.testing.assert_allclose(effects["shadow"], 3 * wide[..., 0], atol=6e-3)


def test_a_nearer_change_fades_in_about_the_face_and_leaves_both_looks_as_they_were():
    ones = np.ones((SIZE, SIZE, 3), np.float32)
    wide, near = ViewChange(ones, 0 * ones, 1.0), ViewChange(3 * ones, 2 * ones, 1.0)
    change = with_nearer_change(wide, near, VIEW, NEARER)
    np.testing.assert_array_equal(wide.gain, ones)
    np.testing.assert_array_equal(wide.offset, 0 * ones)
    np.testing.assert_array_equal(near.gain, 3 * ones)
    share = (change.gain[..., 0] - 1) / 2
    np.testing.assert_allclose(change.offset[..., 0], 2 * share, atol=1e-5)
    np.testing.assert_allclose(share[FACE], 1)
    # The nearer view has a margin of 32 pixels about its middle; beyond it nothing is of it.
    assert share[48:].max() == share[:, :18].max() == 0
    assert 0.05 < share[28, 21] < 0.95


def test_the_light_of_both_looks_counts_alike_and_the_people_alone_tell_the_albedo_s_level():
    wide, near = surface_seen_in(VIEW, 0.5), surface_seen_in(NEARER, 0.4)
    person = torch.ones(1, 1, SIZE, SIZE)
    person[..., :34] = 0
    wide = replace(wide, person=person, albedo=torch.where(person > 0, 0.5, 0.1).expand(1, 3, SIZE, SIZE))
    both = with_nearer_look(wide, replace(near, source_light=3 * near.source_light), VIEW, NEARER)
    torch.testing.assert_close(both.source_light, torch.full_like(both.source_light, 2.0))
    torch.testing.assert_close(both.albedo[..., 48:, 40:], torch.full((1, 3, 16, 24), 0.4), atol=1e-3, rtol=0)


@pytest.mark.parametrize(("near", "kept"), [(0.9, 0.32), (0.02, 0.12)])
def test_the_albedo_around_a_face_follows_a_nearer_look_only_so_far(near, kept):
    albedo = with_nearer_look(surface_seen_in(VIEW, 0.2), surface_seen_in(NEARER, near), VIEW, NEARER).albedo
    torch.testing.assert_close(albedo[..., 48:, :], torch.full((1, 3, 16, SIZE), kept), atol=1e-3, rtol=0)


def test_what_is_white_beside_a_face_reflects_no_more_than_all_light():
    wide = surface_seen_in(VIEW, 0.5)
    wide.albedo[..., 56:, :] = 0.9
    albedo = with_nearer_look(wide, surface_seen_in(NEARER, 0.7), VIEW, NEARER).albedo
    torch.testing.assert_close(albedo[..., 57:, :], torch.ones(1, 3, 7, SIZE))


@pytest.mark.usefixtures("small_and_seeing_faces")
class TestLitNearer:
    NEAR = replace(EDIT, quality=Tier(64, 32, 32, 16, False, lights_nearer=True))
    ONCE = replace(EDIT, quality=Tier(64, 32, 32, 16, False))
    SMALL = FaceBox(40, 30, 62, 54)

    @pytest.fixture
    def relighter(self, weights):
        relighter = Relighter(weights)
        relighter.set_portrait(some_photo(), boxes=[self.SMALL])
        return relighter

    def test_a_small_face_is_lit_by_itself_where_the_tier_has_time(self, relighter):
        near, once = (relighter.relight(some_light(), edit) for edit in (self.NEAR, self.ONCE))
        assert "nearer_face" in near.stages
        assert "nearer_face" not in once.stages
        changed = np.abs(near.image - once.image).max(-1) > 1e-3
        assert changed[30:54, 40:62].any()
        assert np.abs(near.channels["shadow"] - once.channels["shadow"]).max() > 1e-4

    def test_sliders_do_not_light_it_again(self, relighter):
        relighter.relight(some_light(), self.NEAR)
        relit = relighter.relight(some_light(), replace(self.NEAR, shadow=0.5))
        assert states(relit)["nearer_face"] == "reused"

    def test_its_level_is_the_light_s(self, relighter):
        once, eightfold = (relighter.relight(some_light(level=level), self.NEAR) for level in (1.0, 8.0))
        for name in ("composition", "shadow"):
            np.testing.assert_array_equal(eightfold.channels[name], 8 * once.channels[name])

    def test_a_forgotten_stage_runs_again(self, relighter):
        relighter.relight(some_light(), self.NEAR)
        for stage in ("nearer_face", "compose"):
            relighter.forget(stage)
        assert states(relighter.relight(some_light(), self.NEAR))["nearer_face"] == "computed"

    def test_under_the_photo_s_own_light_a_face_in_two_views_is_the_photo(self, relighter, monkeypatch):
        """Each view alone would take another light for the photo's, and another level."""
        tiers = dict(quality.TIERS, final=self.NEAR.quality)
        monkeypatch.setattr(quality, "TIERS", tiers)
        relit = relighter.relight(relighter.estimated_light("final"), replace(EDIT, quality="final"))
        assert "nearer_face" in relit.stages
        face = relighter._faces[0]
        prepared = [view.prepare(self.NEAR.quality) for view in (face, face.nearer)]
        one, other = (view._source_light(ready) for view, ready in zip((face, face.nearer), prepared, strict=True))
        torch.testing.assert_close(one, other)
        part = np.s_[34:50, 44:58]
        difference = np.abs(apply_view(relit.image[part]) - apply_view(some_photo().linear[part]))
        assert difference.mean() < 0.02
