"""Whole outfits on a ball, from a wardrobe of one made-up piece of each kind."""

import json

import numpy as np
import pytest
from ball_heads import CENTRE, RADIUS, assert_well_formed, ball_head, surface
from makehuman_files import quad_proxy

from relight_core.dataset.garments import dressing, fitted_items
from relight_core.dataset.garments.dressing import Shares, Wardrobe
from relight_core.dataset.garments.fitted_items import FittedItem, load_fitted_items
from relight_core.dataset.garments.garment import Garment
from relight_core.dataset.garments.garment_binding import bind
from relight_core.dataset.garments.headwear.wardrobe import Headwear
from relight_core.errors import InputError

KINDS = {
    "wig": "hair",
    "long01": "hair",
    "Full_beard": "beard",
    "brows": "brow",
    "glasses": "glasses",
    "sunglasses": "glasses",
    "fedora": "hat",
    "suit": "cloth",
}
BARE = Shares(headwear=0, arms=0, hair_mass=0)


def piece(model, name, kind):
    """A triangle a hand's breadth from the skin, as large as a hand."""
    corners = np.array([[-4, 6, 14], [4, 6, 14], [0, 12, 14]], np.float32)
    binding = bind(corners, model.mean, np.arange(len(model.mean)), 8)
    uv = np.array([[0, 0], [1, 0], [0, 1]], np.float32)
    return FittedItem(name, kind, corners, np.array([[0, 1, 2]], np.int32), uv, None, None, binding)


@pytest.fixture(scope="module")
def model():
    return ball_head()


def hat(kind, *arguments):
    """One that hides all hair, or else presses it flat."""
    hides = bool(arguments[-1].random() < 0.5)
    corners = np.eye(3, dtype=np.float32)
    name = "hidden" if hides else "pressed"
    return Headwear(
        kind, [Garment(corners, np.array([[0, 1, 2]], np.int32), corners[:, :2], "hat", name=name)], hides, True
    )


@pytest.fixture(scope="module")
def dressed(model):
    """What heads wear by the shares of a wardrobe: by seed, each outfit made once."""
    made = {}
    items = [piece(model, name, kind) for name, kind in KINDS.items()]

    def grown(name, label):
        return lambda *arguments: piece(model, name, label).as_garment(items[0].vertices)

    def by(shares):
        # What has tests of its own counts here for being there.
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(dressing, "load_fitted_items", lambda folder, model: items)
            patch.setattr(dressing, "grow_hair", grown("shell", "hair"))
            patch.setattr(dressing, "grow_mass", grown("mass", "hair"))
            patch.setattr(dressing, "raise_arm", lambda *arguments: [grown("arm", "neck")()])
            patch.setattr(dressing, "put_on", hat)
            wardrobe = Wardrobe("makehuman", model, shares)
            for seed in range(16):
                if (shares, seed) not in made:
                    made[shares, seed] = wardrobe.dress(model.mean, np.random.default_rng(seed))
        return [made[shares, seed] for seed in range(16)]

    return by


def names_of(outfit):
    return [garment.name for garment in outfit]


def share_of(outfits, *names):
    return np.mean([bool(set(names) & set(names_of(outfit))) for outfit in outfits])


def test_heads_wear_what_is_usual_and_nothing_of_what_they_have_no_share_of(dressed):
    outfits = dressed(BARE)
    for outfit in outfits:
        for garment in outfit:
            assert_well_formed(garment)
    assert share_of(outfits, "wig", "long01", "shell") > 0.7
    assert share_of(outfits, "suit") > 0.8
    assert share_of(outfits, "arm", "mass", "fedora") == 0
    assert {garment.label for outfit in outfits for garment in outfit} <= {"hair", "glasses", "cloth", "brow"}


def test_an_outfit_is_the_seeds_own_and_what_few_have_changes_nothing_of_the_rest(dressed):
    plain, armed, massed = dressed(BARE), dressed(Shares(0, 1, 0)), dressed(Shares(0, 0, 1))
    assert share_of(armed, "arm") == share_of(massed, "mass") == 1
    assert len({tuple(names_of(outfit)) for outfit in plain}) > 4
    for bare, arm, mass in zip(plain, armed, massed, strict=True):
        assert names_of(arm)[: len(bare)] == names_of(bare)
        for one, other in zip(bare, arm, strict=False):
            np.testing.assert_array_equal(one.vertices, other.vertices)
        # A mass stands for all other hair of the scalp.
        assert [name for name in names_of(mass) if name != "mass"] == [
            name for name in names_of(bare) if name not in ("wig", "long01", "shell")
        ]


def test_under_headwear_hair_lies_flat_or_is_hidden_and_is_never_a_great_mass(dressed):
    outfits = dressed(Shares(1, 0, 1))
    assert share_of(outfits, "pressed", "hidden", "fedora") == 1
    assert share_of(outfits, "mass") == 0
    for outfit in outfits:
        hair = [garment for garment in outfit if garment.name in ("wig", "long01", "shell")]
        assert not (hair and "hidden" in names_of(outfit))
        for garment in hair:
            away = np.linalg.norm(garment.vertices - CENTRE, axis=1) - RADIUS
            assert away.max() < 1
            # Of hair that was made, only what is flat itself.
            assert garment.name != "wig"
    assert 0.25 < share_of(outfits, "long01", "shell") < 0.65


def test_stiff_pieces_are_scaled_with_the_head_and_not_bent(model):
    items = [piece(model, name, kind) for name, kind in KINDS.items()]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dressing, "load_fitted_items", lambda folder, model: items)
        wardrobe = Wardrobe("makehuman", model)
    wide = (model.mean - CENTRE) * [1.2, 1, 1] + CENTRE
    for item, place in (
        (items[4], lambda head: wardrobe._place_glasses(items[4], head)),
        (items[6], lambda head: wardrobe._place_hat(items[6], head, surface(model, head))),
    ):
        narrow, wider = (np.ptp(place(head).vertices, axis=0) for head in (model.mean, wide))
        assert 1.05 < wider[0] / narrow[0] < 1.2, item.name
        assert wider[1] == pytest.approx(narrow[1], rel=0.02)


@pytest.fixture
def archive(tmp_path, model, monkeypatch):
    """A MakeHuman folder with one quad of each kind, fitted by no warp at all."""
    monkeypatch.setattr(fitted_items, "HeadWarp", lambda base, body, model: lambda points: points)
    monkeypatch.setattr(fitted_items, "_bind", lambda kind, vertices, model: None)
    (tmp_path / "3dobjs").mkdir()
    (tmp_path / "3dobjs" / "base.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng body\nf 1/1 2/2 3/3 4/4\n")
    places = [("hair", "long01"), ("hair", "Full_beard"), ("eyebrows", "eyebrow001"), ("hair", "afro01")]
    places += [("clothes", name) for name in ("glasses", "fedora", "male_casualsuit01", "shoes01")]
    for folder, name in places:
        write_proxy(tmp_path / "proxies" / folder / name)
    return tmp_path


def write_proxy(folder):
    folder.mkdir(parents=True)
    (folder / f"{folder.name}.json").write_text(json.dumps(quad_proxy(0, {})))


def test_an_archive_s_pieces_are_taken_for_what_they_are_and_kept(archive, model):
    expected = {
        ("long01", "hair", "hair"),
        ("Full_beard", "beard", "hair"),
        ("eyebrow001", "brow", "brow"),
        ("glasses", "glasses", "glasses"),
        ("sunglasses", "glasses", "glasses"),
        ("fedora", "hat", "hat"),
        ("male_casualsuit01", "cloth", "cloth"),
    }
    for _ in range(2):
        assert {(item.name, item.kind, item.label) for item in load_fitted_items(archive, model)} == expected
        for path in (archive / "proxies").rglob("*.json"):
            path.unlink()


@pytest.mark.parametrize(
    ("folder", "missing"), [("eyebrows", "no brow here"), ("clothes", "no glasses and no hat and no cloth here")]
)
def test_an_archive_that_is_not_all_there_is_refused_and_taken_once_it_is(archive, model, folder, missing):
    (archive / "proxies" / folder).rename(archive / "not yet")
    with pytest.raises(InputError, match=f"{missing}; give the whole MakeHuman archive"):
        load_fitted_items(archive, model)
    (archive / "not yet").rename(archive / "proxies" / folder)
    assert len(load_fitted_items(archive, model)) == 7


@pytest.mark.parametrize("content", [b"", b"{", b"{}", b"[]", b"\xff\xfe"])
def test_a_damaged_piece_is_named(archive, model, content):
    (archive / "proxies" / "clothes" / "fedora" / "fedora.json").write_bytes(content)
    with pytest.raises(InputError, match=r"fedora\.json: can't be read .*; unpack the MakeHuman archive again"):
        load_fitted_items(archive, model)


@pytest.mark.parametrize("content", [b"v 1 2 three\n", b"g body\nf 1 2 3\n", b"\xff"])
def test_a_damaged_base_is_named(archive, model, content):
    (archive / "3dobjs" / "base.obj").write_bytes(content)
    with pytest.raises(InputError, match=r"base\.obj: can't be read"):
        load_fitted_items(archive, model)
