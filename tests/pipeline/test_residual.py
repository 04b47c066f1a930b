"""What the model misses of a photo: back under the photo's own light, faded where the light is another."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
import torch

from relight_core.pipeline.per_light.hints import Effects
from relight_core.pipeline.per_light.residual import add_residual, at_light_level, find_residual
from relight_core.pipeline.stages import Composed

SIZE = 12
SKIN, INNER_MOUTH, LIPS, NECK, HAIR, CLOTH = 1, 7, 8, 9, 10, 13


def images(seed):
    return torch.rand(1, 3, SIZE, SIZE, generator=torch.Generator().manual_seed(seed)) * 0.8 + 0.05


def surface(photo, label=SKIN):
    parsing = torch.zeros(1, 14, *photo.shape[2:])
    parsing[:, label] = 1
    ahead = torch.tensor([0.0, 0, 1])[None, :, None, None].expand_as(photo)
    person = torch.ones_like(photo[:, :1])
    return SimpleNamespace(photo=photo, albedo=photo, normal=ahead, person=person, parsing=parsing)


def no_effects(size=SIZE):
    zero = torch.zeros(1, 1, size, size)
    return Effects(zero, zero)


def light(level=1.0):
    return torch.full((1, 16, 32, 3), level)


def test_under_its_own_light_the_photo_comes_back():
    photo, model = images(0), Composed(images(1), images(2))
    residual = find_residual(surface(photo), photo, light(3.0), lambda own: model)
    image, _ = add_residual(residual, model, no_effects(), light())
    torch.testing.assert_close(image * residual.level, photo, rtol=1e-4, atol=1e-5)


def test_the_model_sees_a_normalised_light():
    seen, photo = [], images(0)
    model = Composed(images(1), images(1))
    find_residual(surface(photo), photo, light(7.0), lambda own: seen.append(own) or model)
    torch.testing.assert_close(seen[0], light(1.0))


def test_a_model_that_only_has_the_wrong_level_leaves_no_residual():
    photo = images(0)
    residual = find_residual(surface(photo), photo, light(), lambda own: Composed(2 * photo, photo))
    assert residual.log_ratio.abs().max() < 1e-3
    assert abs(residual.level - 0.5) < 1e-4


def test_it_fades_as_a_place_is_lit_less_like_in_the_photo():
    photo, model = images(0), Composed(images(1), torch.full((1, 3, SIZE, SIZE), 1.0))
    residual = find_residual(surface(photo), photo, light(), lambda own: model)
    changes = []
    for brightness in (1.0, 0.5, 0.1, 0.0):
        plain = torch.full((1, 3, SIZE, SIZE), brightness)
        image, _ = add_residual(residual, Composed(model.image, plain), no_effects(), light())
        # What the camera adds to the colour of all skin stays.
        changes.append(float(((image / model.image).log() - residual.tint).abs().mean()))
    assert changes == sorted(changes, reverse=True)
    assert changes[-1] < 0.005


def test_hair_that_the_model_makes_too_bright_stays_dark_in_a_stronger_light_but_too_dark_hair_does_not_shine():
    photo = torch.full((1, 3, SIZE, SIZE), 0.1)
    photo[..., : SIZE // 2] = 0.4
    model = Composed(torch.full_like(photo, 0.2), torch.full_like(photo, 0.2))
    brighter = Composed(torch.full_like(photo, 2.0), torch.full_like(photo, 2.0))

    def gains(label):
        residual = find_residual(surface(photo, label), photo, light(), lambda own: model)
        image, _ = add_residual(residual, brighter, no_effects(), light())
        return (image / brighter.image)[0, 0, 0]

    cloth, hair = gains(CLOTH), gains(HAIR)
    assert hair[-1] < cloth[-1] - 0.1
    torch.testing.assert_close(hair[0], cloth[0])


@pytest.mark.parametrize(("own", "hair_there", "darkest"), [(0.15, 0.2, 0.5), (0.4, 0.2, 0.9), (0.15, 0.0, 0.9)])
def test_a_beards_edge_taken_for_the_neck_stays_dark_but_a_shaded_neck_does_not(own, hair_there, darkest):
    photo, model = (torch.full((1, 3, SIZE, SIZE), 0.2) for _ in range(2))
    edge = (..., slice(0, 3), slice(0, 3))
    photo[edge] = 0.02
    there = surface(photo)
    there.albedo = torch.full_like(photo, 0.4)
    there.albedo[edge] = own
    for label, share in ((SKIN, 0.0), (NECK, 0.8), (HAIR, hair_there)):
        there.parsing[0, label, :3, :3] = share
    residual = find_residual(there, photo, light(), lambda own_light: Composed(model, 0.1 * model))
    brighter = Composed(torch.full_like(photo, 2.0), torch.full_like(photo, 2.0))
    image, _ = add_residual(residual, brighter, no_effects(), light())
    kept = float(image[0, 0, 1, 1]) / 2
    assert kept < darkest if darkest < 0.6 else kept > 0.6


def test_on_skin_a_mole_stays_longer_than_a_highlight_or_a_shaded_cheek():
    photo = torch.full((1, 3, SIZE, SIZE), 0.2)
    photo[..., :4] = 0.1
    photo[..., 3, 9], photo[..., 9, 9] = 0.1, 0.4
    model = Composed(torch.full_like(photo, 0.2), torch.full_like(photo, 0.2))
    brighter = Composed(torch.full_like(photo, 0.4), torch.full_like(photo, 0.4))
    residual = find_residual(surface(photo, SKIN), photo, light(), lambda own: model)
    image, _ = add_residual(residual, brighter, no_effects(), light())
    log_kept = ((image + 0.005) / (brighter.image + 0.005)).log() / residual.log_ratio
    cheek, mole, highlight = (float(log_kept[0, 0, y, x]) for y, x in ((6, 0), (3, 9), (9, 9)))
    assert cheek < 0.2
    assert highlight < 0.2
    assert mole > 0.35


def test_a_narrow_shadow_that_the_photos_light_left_on_skin_fades_and_a_mole_stays():
    size = 100
    photo = torch.full((1, 3, size, size), 0.2)
    photo[..., 40:46], photo[..., 70, 70] = 0.1, 0.1
    model, brighter = (Composed(torch.full_like(photo, grey), torch.full_like(photo, grey)) for grey in (0.2, 0.4))
    residual = find_residual(surface(photo, SKIN), photo, light(), lambda own: model)
    image, _ = add_residual(residual, brighter, no_effects(size), light())
    log_kept = ((image + 0.005) / (brighter.image + 0.005)).log() / residual.log_ratio
    assert log_kept[0, 0, 50, 42:44].max() < 0.2
    assert log_kept[0, 0, 70, 70] > 0.35


def test_a_clipped_photo_does_not_darken_a_brighter_model():
    photo, model = torch.ones(1, 3, SIZE, SIZE), Composed(images(1), images(1))
    photo[:, :, : SIZE // 2] = model.image[:, :, : SIZE // 2] * 0.5
    model.image[:, :, SIZE // 2 :] = 5.0
    residual = find_residual(surface(photo), photo, light(), lambda own: model)
    assert residual.log_ratio[:, :, SIZE // 2 :].min() >= 0


@pytest.mark.parametrize("radiance", [3.0, 60.0])
def test_radiance_above_1_comes_back_where_the_file_holds_it(radiance):
    photo, model = images(0), Composed(images(1).clamp_min(0.4), images(2))
    recorded = photo.clone()
    recorded[:, :, :4] = radiance
    residual = find_residual(surface(photo.clamp_max(1)), recorded, light(), lambda own: model)
    image, _ = add_residual(residual, model, no_effects(), light())
    torch.testing.assert_close(image * residual.level, recorded, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("overshoot", [0.0015, 0.3])
def test_a_pixel_just_above_1_does_not_undo_what_was_clipped(overshoot):
    photo, model = torch.ones(1, 3, SIZE, SIZE), Composed(images(1), images(1))
    photo[:, :, : SIZE // 2] = model.image[:, :, : SIZE // 2] * 0.5
    model.image[:, :, SIZE // 2 :] = 5.0
    over = photo.clone()
    over[:, :, 0, 0] += photo.amax() + overshoot - over[:, :, 0, 0]
    clipped, nearly = (find_residual(surface(photo), seen, light(), lambda own: model) for seen in (photo, over))
    off = (nearly.log_ratio - clipped.log_ratio)[:, :, SIZE // 2 :].abs()
    assert off.max() < 0.1


def test_black_and_blown_out_photos_stay_finite():
    for value in (0.0, 1.0):
        for modelled in (0.0, 1e4):
            model = Composed(torch.full((1, 3, SIZE, SIZE), modelled), torch.zeros(1, 3, SIZE, SIZE))
            photo = torch.full((1, 3, SIZE, SIZE), value)
            residual = find_residual(surface(photo), photo, light(0.0), lambda own, model=model: model)
            image, effects = add_residual(residual, model, no_effects(), light())
            assert torch.isfinite(image).all()
            assert image.min() >= 0
            assert torch.isfinite(effects.specular).all()


def blown(label, model_colour):
    photo, model = torch.full((1, 3, SIZE, SIZE), 0.4), torch.full((1, 3, SIZE, SIZE), 0.4)
    photo[:, :, :6] = 1.0
    model[:, :, :6] = torch.tensor(model_colour)[None, :, None, None]
    residual = find_residual(surface(photo, label), photo, light(), lambda own: Composed(model, model))
    return residual.log_ratio[0, :, 3, 3]


def test_blown_skin_is_made_brighter_in_its_own_colour():
    red, green, blue = blown(SKIN, (0.8, 0.5, 0.4))
    assert red > 0
    torch.testing.assert_close(green, red)
    torch.testing.assert_close(blue, red)


def test_other_things_that_are_blown_become_white_and_no_darker():
    log_ratio = blown(CLOTH, (1.6, 1.4, 2.0))
    relit = torch.tensor([1.6, 1.4, 2.0]) * log_ratio.exp()
    torch.testing.assert_close(relit, relit[:1].expand(3), atol=0.02, rtol=0)
    assert relit.mean() > 1.4


def reddened(label, share):
    """Log of red over blue, relative to its model, of a flat brown thing: relit in a quarter of the light, and in its
    photo, which shows so much more of its colour than the model does."""
    albedo = torch.tensor([0.4, 0.25, 0.16])[None, :, None, None].expand(1, 3, SIZE, SIZE)
    own = albedo.log() - albedo.log().mean(1, keepdim=True)
    photo, model = albedo * torch.exp(share * own), Composed(albedo, torch.ones(1, 3, SIZE, SIZE))
    seen = surface(photo, label)
    seen.albedo = albedo
    residual = find_residual(seen, photo, light(), lambda own_light: model)
    image, _ = add_residual(residual, Composed(0.25 * albedo, 0.25 * model.plain), no_effects(), light())
    change = (image / (0.25 * albedo)).log()[0, :, 0, 0]
    return float(change[0] - change[2]), float(share * (own[0, 0, 0, 0] - own[0, 2, 0, 0]))


def test_what_a_camera_adds_to_the_colour_of_skin_it_adds_in_any_light():
    kept, added = reddened(SKIN, 0.2)
    assert 0.8 * added < kept < 1.2 * added


def test_no_camera_adds_more_than_three_fifths_to_the_colour_of_skin():
    within, beyond, far_beyond = (reddened(SKIN, share)[0] for share in (0.5, 0.8, 1.5))
    assert within < beyond < 1.35 * within
    assert far_beyond == pytest.approx(beyond, rel=0.1)


def test_a_light_that_takes_from_the_skins_colour_is_not_the_cameras():
    kept, missing = reddened(SKIN, -0.2)
    assert abs(kept) < 0.1 * abs(missing)


@pytest.mark.parametrize("label", [HAIR, CLOTH])
@pytest.mark.parametrize("share", [0.2, -0.2])
def test_what_is_not_skin_keeps_the_colour_that_it_has_beside_its_model(label, share):
    kept, off = reddened(label, share)
    assert kept == pytest.approx(off, rel=0.2)


def _ratios_in_white_light(code, label):
    """Channels over green of a grey patch of a photo under a warm light, in a white light of the same strength."""
    photo = torch.full((1, 3, SIZE, SIZE), code)
    warm = torch.tensor([1.0, 0.5, 0.2])[None, :, None, None]
    looks = SimpleNamespace(**{**vars(surface(photo, label)), "albedo": torch.full_like(photo, 0.05)})
    lit = torch.full_like(photo, 0.05)
    residual = find_residual(looks, photo, light(), lambda own: Composed(lit * warm, lit))
    image, _ = add_residual(residual, Composed(lit, lit), no_effects(), lamp(3))
    back, _ = add_residual(residual, Composed(lit * warm, lit), no_effects(), light())
    torch.testing.assert_close(back * residual.level, photo, rtol=1e-3, atol=1e-5)
    return (image / image[:, 1:2])[0, :, 5, 5]


@pytest.mark.parametrize("label", [HAIR, CLOTH])
def test_black_hair_and_cloth_under_a_warm_light_are_not_blue_in_a_white_one_but_grey_that_is_seen_is(label):
    torch.testing.assert_close(_ratios_in_white_light(0.005, label), torch.ones(3), rtol=0.02, atol=0.02)
    assert _ratios_in_white_light(0.1, label)[2] > 1.5


def lamp(column):
    light = torch.full((1, 16, 32, 3), 0.005)
    light[:, 8, column] = 20.0
    return light


def rim_in(light_of_the_other_picture, label=SKIN, rim=0.9):
    """How much brighter than the rest a short rim is that the model doesn't know, though all of it is lit alike."""
    photo, flat = torch.full((1, 3, SIZE, SIZE), 0.2), torch.full((1, 3, SIZE, SIZE), 0.2)
    photo[..., 5:7, 4] = rim
    model = Composed(flat, torch.ones_like(flat))
    residual = find_residual(surface(photo, label), photo, lamp(2), lambda own: model)
    image, _ = add_residual(residual, model, no_effects(), light_of_the_other_picture)
    return float(image[..., 5:7, 4].mean() / image[..., 10].mean())


@pytest.mark.parametrize("label", [SKIN, HAIR])
def test_a_rim_of_light_from_behind_stays_only_where_the_light_comes_from_there(label):
    own, turned, other = (rim_in(lamp(column), label) for column in (2, 3, 18))
    assert own == pytest.approx(4.5, rel=0.01)
    assert other < 1.1
    assert other < turned < own


def purple_patch_in(light_of_the_other_picture, brightness):
    """Log of blue over green of a patch of skin of that brightness in a photo, purple where its model is grey."""
    photo, flat = torch.full((1, 3, SIZE, SIZE), 0.2), torch.full((1, 3, SIZE, SIZE), 0.2)
    photo[..., 4:8, 4:8] = brightness * torch.tensor([1.1, 0.9, 1.3])[None, :, None, None]
    flat[..., 4:8, 4:8] = brightness
    model = Composed(flat, torch.ones_like(flat))
    residual = find_residual(surface(photo), photo, lamp(2), lambda own: model)
    image, _ = add_residual(residual, model, no_effects(), light_of_the_other_picture)
    return float((image[0, 2, 6, 6] / image[0, 1, 6, 6]).log())


def test_a_colour_of_skin_in_deep_shadow_stays_only_in_its_own_light_and_paint_that_is_seen_in_any():
    seen = pytest.approx(0.37, abs=0.05)
    assert purple_patch_in(lamp(2), 0.03) == seen
    assert abs(purple_patch_in(lamp(18), 0.03)) < 0.05
    assert purple_patch_in(lamp(18), 0.2) == seen


def mask_in_a_dimmer_light(height, known=0.0):
    """Log of blue over red of a blue mask (1.39 in its photo) amid skin, of which the model knows a part."""
    size, skin, blue = 48, (0.4, 0.25, 0.2), (0.1, 0.25, 0.4)
    model = torch.tensor(skin)[None, :, None, None].expand(1, 3, size, size).contiguous()
    photo, rows = model.clone(), slice(24 - height // 2, 24 + height // 2)
    photo[..., rows, 14:34] = torch.tensor(blue)[None, :, None, None]
    model[..., rows, 14:34] *= (photo / model)[..., rows, 14:34] ** known
    there = surface(photo)
    there.albedo = model
    residual = find_residual(there, photo, lamp(2), lambda own: Composed(model, torch.ones_like(model)))
    dimmer = Composed(0.2 * model, torch.full_like(model, 0.2))
    image, _ = add_residual(residual, dimmer, no_effects(size), lamp(18))
    return float((image[0, 2, 24, 24] / image[0, 0, 24, 24]).log())


def test_a_mask_that_the_albedo_has_as_skin_keeps_its_colour_in_another_light_and_a_narrow_band_fades():
    for known in (0.0, 0.5):
        assert mask_in_a_dimmer_light(16, known) == pytest.approx(1.39, abs=0.2)
    assert mask_in_a_dimmer_light(2) < 0


def test_a_pattern_that_the_model_misses_stays_in_any_light():
    assert rim_in(lamp(18), CLOTH) == pytest.approx(4.5, rel=0.01)
    assert rim_in(lamp(18), SKIN, rim=0.23) == pytest.approx(1.15, rel=0.02)


def test_at_another_level_the_photo_comes_back_too():
    photo, model = images(0).clamp_min(0.2), Composed(images(1).clamp_min(0.2), images(2))
    residual = at_light_level(find_residual(surface(photo), photo, light(), lambda own: model), 0.5)
    image, _ = add_residual(residual, model, no_effects(), light())
    torch.testing.assert_close(image * 0.5, photo, rtol=0.02, atol=0)


def test_no_light_at_all_leaves_a_residual_as_it_is():
    photo = images(0)
    residual = find_residual(surface(photo), photo, light(), lambda own: Composed(photo, photo))
    assert at_light_level(residual, 0.0) is residual
    without_light = replace(residual, level=0.0)
    assert at_light_level(without_light, 0.5) is without_light


def test_at_a_level_far_from_its_own_a_face_is_changed_within_limits():
    """Beside a lit face, one that the others' light would leave black or make a lamp of."""
    photo = images(0).clamp_min(0.2)
    residual = find_residual(surface(photo), photo, light(), lambda own: Composed(photo, photo))
    for level, farthest in ((1e-4 * residual.level, 3.0), (1e4 * residual.level, -3.0)):
        assert at_light_level(residual, level).log_ratio.unique().tolist() == [farthest]


def test_what_a_level_darkens_is_of_all_skin_and_fades_as_whole_cheeks_do():
    photo = torch.full((1, 3, SIZE, SIZE), 0.4)
    residual = find_residual(surface(photo), photo, light(), lambda own: Composed(photo, photo))
    half_as_lit = Composed(photo, 0.5 * photo)
    image, _ = add_residual(at_light_level(residual, 2 * residual.level), half_as_lit, no_effects(), light())
    torch.testing.assert_close(image / photo, torch.full_like(photo, 2**-0.125), rtol=0.01, atol=0)


def test_gloss_and_shadow_of_a_view_change_as_the_view_does():
    photo, model = images(0).mean(1, keepdim=True).expand(1, 3, SIZE, SIZE), torch.full((1, 3, SIZE, SIZE), 0.5)
    residual = find_residual(surface(photo), photo, light(), lambda own: Composed(model, model))
    one = torch.ones(1, 1, SIZE, SIZE)
    image, effects = add_residual(residual, Composed(model, model), Effects(0.3 * one, 0.2 * one), light())
    by = (image + 0.005)[:, :1] / 0.505
    assert by.max() > 1.2 * by.min()
    torch.testing.assert_close(effects.specular, 0.3 * by, rtol=1e-3, atol=0)
    torch.testing.assert_close(effects.shadow, 0.2 * by, rtol=1e-3, atol=0)


def mouth_in(light_of_the_other_picture, shown, label=LIPS, albedo=(0.5, 0.3, 0.3), dimmed=1.0):
    """(3,) what a photo's mouth becomes whose light is taken for a warm one; in None, that light itself."""
    photo, own = (torch.tensor(colour)[None, :, None, None].expand(1, 3, SIZE, SIZE) for colour in (shown, albedo))
    warm, seen = own * torch.tensor([1.4, 1.0, 0.6])[None, :, None, None], surface(photo, label)
    seen.albedo = own
    residual = find_residual(seen, photo, light(), lambda light: Composed(warm, torch.ones_like(warm)))
    model, other = (warm, light()) if light_of_the_other_picture is None else (own, light_of_the_other_picture)
    image, _ = add_residual(residual, Composed(dimmed * model, dimmed * torch.ones_like(model)), no_effects(), other)
    return image[0, :, 0, 0] * residual.level


@pytest.mark.parametrize("label", [LIPS, INNER_MOUTH])
def test_a_mouth_that_is_less_warm_than_its_light_turns_no_bluer_than_the_photo_shows_it(label):
    for dimmed in (1.0, 0.1):
        _, green, blue = mouth_in(lamp(20), (0.26, 0.2, 0.24), label, dimmed=dimmed)
        assert blue / green == pytest.approx(1.2, abs=0.03)
    _, green, blue = mouth_in(lamp(20), (0.26, 0.2, 0.18), label)
    assert blue / green == pytest.approx(1.1, abs=0.03)


def test_cloth_that_is_less_warm_than_its_light_is_as_blue_as_that_says_and_a_mouth_in_its_own_light_as_it_was():
    _, green, blue = mouth_in(lamp(20), (0.26, 0.2, 0.24), CLOTH)
    assert blue / green == pytest.approx(1.2 / 0.6, rel=0.05)
    for label in (LIPS, INNER_MOUTH):
        torch.testing.assert_close(mouth_in(None, (0.26, 0.2, 0.24), label), torch.tensor([0.26, 0.2, 0.24]))


def test_a_purple_mouth_stays_purple():
    _, green, blue = mouth_in(lamp(20), (0.3, 0.1, 0.2), LIPS, (0.3, 0.1, 0.3))
    assert blue / green == pytest.approx(3.0, abs=0.2)
