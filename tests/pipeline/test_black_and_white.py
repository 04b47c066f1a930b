"""Photos without colour: no network's guess and no light may give them any."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from tiny_relighter import EDIT, some_light, some_photo

from relight_core.face.find import FaceBox
from relight_core.imaging.colour import luminance
from relight_core.imaging.photo import Photo
from relight_core.imaging.tone import tone_of
from relight_core.lighting.environment import Environment
from relight_core.pipeline.face_taken_apart import Workshop
from relight_core.pipeline.per_photo.brush import BrushStroke
from relight_core.pipeline.per_photo.portrait import frame
from relight_core.pipeline.quality import Tier
from relight_core.pipeline.relighter import Relighter
from relight_core.pipeline.results.channels import ViewChange


def black_and_white(photo=None):
    grey = (photo or some_photo()).linear.mean(-1, keepdims=True)
    return Photo(np.ascontiguousarray(np.repeat(grey, 3, -1)))


def of_greys(image):
    return float(np.ptp(image, axis=-1).max()) < 1e-6


class TestRecognition:
    def test_greys_of_all_levels(self):
        assert black_and_white().monochrome
        assert Photo(np.zeros((8, 8, 3), np.float32)).monochrome

    def test_colours_that_compression_makes_are_none(self):
        codes = np.random.default_rng(0).integers(20, 230, (64, 64, 1)) + np.random.default_rng(1).integers(
            0, 3, (64, 64, 3)
        )
        assert Photo.from_srgb(codes.astype(np.uint8)).monochrome

    def test_one_coloured_part_makes_a_colour_photo(self):
        linear = black_and_white().linear.copy()
        linear[:10, :20, 0] *= 1.5
        assert not Photo(linear).monochrome

    @pytest.mark.parametrize("tone", [(1.1, 1.0, 0.7), (0.98, 1.0, 1.06)])
    def test_a_tone_all_over_is_no_colour(self, tone):
        assert Photo(black_and_white().linear * np.float32(tone)).monochrome

    @pytest.mark.parametrize("factor", [1e-5, 1.0, 30.0, 1e4])
    @pytest.mark.parametrize("lamp", [0.0, 60.0])
    def test_a_floating_point_photo_has_its_colours_in_whatever_units(self, factor, lamp):
        for photo, colourless in ((some_photo(), False), (black_and_white(), True)):
            linear = photo.linear * np.float32((1.25, 1.0, 0.6)) * np.float32(factor)
            linear[:2, :2] += lamp
            assert Photo(linear, bits=32).monochrome == colourless

    def test_a_tone_that_leaves_the_gamut_here_and_there_is_no_colour(self):
        toned = black_and_white().linear * np.float32((1.1, 1.0, 0.7)) - np.float32((0, 0, 0.002))
        toned[:2] = (0.0005, 0.0005, -0.0015)
        assert Photo(np.maximum(toned, 0), beyond=np.minimum(toned, 0).astype(np.float16)).monochrome

    def test_a_colour_that_lies_beyond_the_gamut_alone_is_one(self):
        grey = black_and_white().linear
        beyond = np.zeros(grey.shape, np.float16)
        beyond[:20, :20, 0] = -0.1
        assert not Photo(grey, beyond=beyond).monochrome

    def test_neither_is_one_in_the_shadows_alone(self):
        grey = black_and_white().linear
        assert Photo(np.ascontiguousarray(grey * (1 - np.float32([0, 0, 0.4]) * (1 - grey)))).monochrome

    def test_a_cream_page_is_no_part_of_a_print_s_tone(self):
        grey = black_and_white().linear
        framed = cv2.copyMakeBorder(grey * np.float32(0.9), *(12,) * 4, cv2.BORDER_CONSTANT, value=(0.99, 0.9, 0.7))
        assert Photo(framed).monochrome
        assert Photo(framed).tone_at(1.0) is None

    def test_a_photo_of_pale_colours_is_a_colour_photo(self):
        rng = np.random.default_rng(0)
        pale = black_and_white().linear * (1 + 0.15 * rng.standard_normal((1, 1, 3)))
        half = pale.shape[1] // 2
        pale[:, :half] = black_and_white().linear[:, :half]
        assert not Photo(pale.astype(np.float32)).monochrome


@pytest.mark.usefixtures("small_and_seeing_faces")
class TestRelighting:
    @pytest.mark.parametrize("background", ["keep", "match", "light"])
    def test_a_coloured_light_leaves_it_without_colour(self, weights, background):
        relighter = Relighter(weights)
        relighter.set_portrait(black_and_white())
        relit = relighter.relight(some_light(), replace(EDIT, background=background, specular_tint=1.0))
        assert of_greys(relit.image)
        assert relit.image.std() > 0.01
        assert of_greys(relit.channels["albedo"])
        assert of_greys(relit.channels["composition"])
        assert of_greys(relighter.estimated_light("live").shape)

    def test_nor_is_there_colour_behind_the_person(self, weights):
        relighter = Relighter(weights)
        relighter.set_portrait(black_and_white(), strokes=[BrushStroke(((104.0, 48.0),), 7.0, False)])
        relit = relighter.relight(some_light(), replace(EDIT, background="light"))
        assert of_greys(relit.image)
        kept = relighter.relight(some_light(), EDIT)
        assert np.abs(relit.image - kept.image)[46:50, 102:106].min() > 1e-3

    def test_a_toned_photo_keeps_its_tone(self, weights):
        sepia = black_and_white().linear * np.float32([1.1, 1.0, 0.7])
        relighter = Relighter(weights)
        relighter.set_portrait(Photo(sepia))
        relit = relighter.relight(some_light(), EDIT).image
        assert relit.std() > 0.01
        lit = relit[..., 0] > 0.02
        np.testing.assert_allclose(relit[lit][:, 2] / relit[lit][:, 0], 0.7 / 1.1, rtol=0.02)

    def test_what_was_white_takes_the_tone_of_what_it_is_dimmed_to(self, weights):
        grey = black_and_white().linear[..., :1]
        split = grey * (1 + np.float32([0.2, 0, -0.4]) * 4 * grey * (1 - grey))
        relighter = Relighter(weights)
        relighter.set_portrait(Photo(np.ascontiguousarray(split)))
        relit = relighter.relight(some_light(), EDIT).image
        own = Photo(np.ascontiguousarray(split)).tone_at(1.0)
        brightness = luminance(relit)
        lit = brightness > 0.02
        off = np.abs((relit / brightness[..., None])[lit] - own.at(brightness[lit]))
        assert np.percentile(off, 99) < 0.05

    def test_a_dark_print_takes_the_tone_of_what_it_is_brightened_to(self, weights):
        grey = black_and_white().linear[..., :1]
        split = grey * (1 + np.float32([0.2, 0, -0.4]) * 4 * grey * (1 - grey))
        dark = Photo(np.ascontiguousarray(split / 64), bits=32)
        relighter = Relighter(weights)
        relighter.set_portrait(dark)
        relit = relighter.relight(some_light(level=4.0), EDIT).image[32:64, 40:56]
        brightness = luminance(relit)
        own = dark.tone_at(relighter._faces[0].portrait.exposure)
        lit = brightness > 0.02
        off = np.abs((relit / brightness[..., None])[lit] - own.at(brightness[lit]))
        assert np.percentile(off, 99) < 0.05

    @pytest.mark.parametrize("tone", [(1.1, 1.0, 0.7), (0.75, 1.0, 1.4)])
    def test_a_tone_changes_nothing_but_the_tone(self, weights, tone):
        grey = black_and_white().linear * np.float32(0.6)
        tone = np.float32(tone) / luminance(np.float32(tone))
        found = []
        for linear in (grey, grey * tone):
            relighter = Relighter(weights)
            relighter.set_portrait(Photo(linear))
            relit = relighter.relight(some_light(), replace(EDIT, quality="final"))
            assert of_greys(relit.channels["albedo"])
            found.append((luminance(relit.channels["composition"]), relit.full.changes[0].gain))
        for plain, toned in zip(*found, strict=True):
            # The networks' own rounding makes 0.0001 of it.
            assert np.abs(toned - plain).mean() < 1e-3 * plain.mean()

    def test_no_network_sees_a_tone(self, weights, monkeypatch):
        seen, delight = [], Workshop.delight
        monkeypatch.setattr(Workshop, "delight", lambda shop, *args: seen.append(args[0]) or delight(shop, *args))
        relighter, sepia = Relighter(weights), black_and_white().linear * np.float32([1.1, 1.0, 0.7])
        relighter.set_portrait(Photo(sepia))
        relit = relighter.relight(some_light(), EDIT)
        assert len(seen) > 1
        assert all(of_greys(view) for view in seen)
        assert not of_greys(relit.channels["photo"])

    @pytest.mark.parametrize("background", ["keep", "light"])
    def test_a_coloured_mark_beside_a_grey_face_gives_it_no_colour(self, weights, background):
        marked = black_and_white().linear
        marked[84:92, 2:10] = (0.8, 0.1, 0.1)
        relighter = Relighter(weights)
        relighter.set_portrait(Photo(marked), boxes=[FaceBox(60, 20, 90, 55)])
        relit = relighter.relight(some_light(), replace(EDIT, background=background, specular_tint=1.0))
        assert not Photo(marked).monochrome
        assert of_greys(relit.channels["albedo"])
        assert of_greys(relit.image[:, 20:])

    def test_a_face_of_colours_has_them_before_grey_walls(self):
        walls = black_and_white().linear
        walls[15:60, 55:95] *= np.float32([1.2, 1.0, 0.8])
        face = FaceBox(60, 20, 90, 55)
        assert not frame(Photo(walls), face).monochrome
        assert not frame(Photo(walls * np.float32(0.02), bits=32), face).monochrome
        assert frame(black_and_white(), face).monochrome

    def test_colours_around_a_grey_face_are_not_its_own(self):
        surrounded, face = black_and_white().linear, FaceBox(60, 20, 90, 55)
        crop = frame(Photo(surrounded), face).crop
        x0, y0, x1, y1 = map(round, crop.window)
        coloured = surrounded * np.float32([1.2, 1.0, 0.7])
        coloured[max(y0, 0) : y1, max(x0, 0) : x1] = surrounded[max(y0, 0) : y1, max(x0, 0) : x1]
        assert not Photo(coloured).monochrome
        assert frame(Photo(coloured), face).monochrome

    @pytest.mark.parametrize("part", [(slice(48, 54), slice(68, 82)), (slice(0, 18), slice(None))])
    def test_lips_or_a_hat_left_coloured_keep_their_colour_and_give_none_to_a_grey_face(self, weights, part):
        linear = black_and_white().linear
        linear[part] = luminance(linear[part])[..., None] * np.float32([2.5, 0.6, 0.5])
        coloured = np.zeros(linear.shape[:2], bool)
        coloured[part] = True
        relighter = Relighter(weights)
        relighter.set_portrait(Photo(linear), boxes=[FaceBox(60, 20, 90, 55)])
        relit = relighter.relight(some_light(), EDIT).image
        assert not Photo(linear).monochrome
        # Near the border, resampling mixes both sides; farther off it carries a trace, less than a code.
        grey = ~cv2.dilate(coloured.astype(np.uint8), np.ones((9, 9), np.uint8)).astype(bool)
        assert (np.ptp(relit[grey], axis=-1) < 1e-3 * relit[grey].mean(-1)).all()
        kept = relit[coloured]
        assert kept[:, 1].min() > 0.01
        np.testing.assert_allclose(kept[:, 0] / kept[:, 1], 2.5 / 0.6, rtol=0.15)

    def test_a_light_keeps_its_colours_before_a_face_of_colours_beside_a_grey_one(self, weights):
        photo = np.random.default_rng(0).uniform(0.2, 0.8, (96, 240, 3)).astype(np.float32)
        photo[:, 120:] = photo[:, 120:].mean(-1, keepdims=True)
        relighter = Relighter(weights)
        relighter.set_portrait(Photo(photo), boxes=[FaceBox(28, 16, 64, 72), FaceBox(176, 16, 212, 72)])
        # Of a level at which gains are about 1, since single precision rounds larger ones by more.
        radiance = some_light().shape * np.float32([0.5, 0.2, 0.05])
        relit = relighter.relight(Environment.from_radiance(radiance), replace(EDIT, background="light"))
        own, printed = relit.full.changes
        assert own.gain[..., 0].mean() > 1.5 * own.gain[..., 2].mean()
        assert of_greys(printed.gain)
        assert not of_greys(relit.full.backdrop.picture)

    def test_a_tier_whose_view_no_network_size_divides(self, weights):
        relighter = Relighter(weights)
        relighter.set_portrait(black_and_white())
        assert of_greys(relighter.relight(some_light(), replace(EDIT, quality=Tier(72, 32, 32, 16, False))).image)

    def test_a_light_s_colours_act_by_their_luminance(self, weights):
        light = some_light()
        luminance = light.shape @ np.float32([0.2126, 0.7152, 0.0722])
        colourless = Environment(np.repeat(luminance[..., None], 3, -1), light.level, "grey")
        relighter = Relighter(weights)
        relighter.set_portrait(black_and_white())
        coloured, grey = (relighter.relight(one, EDIT).image for one in (light, colourless))
        np.testing.assert_allclose(coloured, grey, rtol=1e-3, atol=1e-4)

    def test_a_colour_photo_keeps_its_colours(self, weights):
        relighter = Relighter(weights)
        relighter.set_portrait(some_photo())
        assert not of_greys(relighter.relight(some_light(), EDIT).image)


def test_light_that_is_added_to_a_toned_photo_has_the_tone_of_what_it_makes():
    steps = np.linspace(0, 1, 5000, dtype=np.float32)[:, None]
    print_of = steps * (1 + (1 - steps) * np.float32([0.3, -0.05, -0.4]))
    tone = tone_of(print_of)
    nothing, photo = np.zeros((2, 2, 3), np.float32), np.full((2, 2, 3), 0.9, np.float32) * tone.at(np.float32(0.9))
    shown = ViewChange(nothing, nothing + 0.2, 1.0).toned(photo, tone).apply(photo)
    np.testing.assert_allclose(shown[0, 0], 0.2 * tone.at(np.float32(0.2)), rtol=0.02)
