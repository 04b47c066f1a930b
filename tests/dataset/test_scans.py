"""A folder of scanned people in place of a head model."""

import numpy as np
import pytest
from PIL import Image
from synthetic_heads import ball

from relight_core.dataset import recipe
from relight_core.dataset.baking.shard import read_shard
from relight_core.dataset.painting.skin import paint
from relight_core.dataset.painting.texture import TexturePool
from relight_core.dataset.recipe import ScanCasting, bake_missing, load_casting
from relight_core.dataset.scans import people_of, read_scan
from relight_core.errors import InputError

SKIN, HAIR = 1, 10


def write_scan(folder, name="neutral", size_cm=20.0, colour=(200, 120, 80)):
    """A square sheet of two triangles, its upper half hair, its lower half skin."""
    folder.mkdir(parents=True, exist_ok=True)
    half = size_cm / 2
    (folder / f"{name}.obj").write_text(
        f"v {-half} {-half} 50\nv {half} {-half} 50\nv {half} {half} 50\nv {-half} {half} 50\n"
        f"v {-half} 0 52\nv {half} 0 52\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0 0.5\nvt 1 0.5\n"
        "f 1/1 2/2 6/6 5/5\nf -2/-2 -1/-1 3/3 4/4\n"
    )
    labels = np.full((8, 8), SKIN, np.uint8)
    labels[:4] = HAIR
    Image.fromarray(labels).save(folder / f"{name}.labels.png")
    Image.fromarray(np.full((4, 4, 3), colour, np.uint8)).save(folder / f"{name}.albedo.png")


def test_a_scan_is_read_and_moved_to_the_head_models_place(tmp_path):
    write_scan(tmp_path / "anna")
    scan = read_scan(tmp_path / "anna" / "neutral.obj")
    assert scan.triangles.shape == (4, 3)
    assert scan.material.tolist() == [0, 0, 6, 6]
    assert set(scan.face.tolist()) == {0, 1, 4, 5}
    low, high = scan.vertices[scan.face].min(0), scan.vertices[scan.face].max(0)
    np.testing.assert_allclose((low + high) / 2, [0, -1, 10], atol=1e-4)
    np.testing.assert_allclose(scan.albedo[3, 3], (np.array([200, 120, 80]) / 255) ** 2.2, atol=0.02)


def test_pictures_may_be_shared_by_a_person(tmp_path):
    write_scan(tmp_path / "anna", "anna")
    (tmp_path / "anna" / "smile.obj").write_text((tmp_path / "anna" / "anna.obj").read_text())
    np.testing.assert_array_equal(
        read_scan(tmp_path / "anna" / "smile.obj").albedo, read_scan(tmp_path / "anna" / "anna.obj").albedo
    )


def test_people_are_split_as_wholes(tmp_path):
    for number in range(12):
        for name in ("neutral", "smile"):
            write_scan(tmp_path / f"person {number}", name)
    people = {split: people_of(tmp_path, split) for split in ("train", "validation", "test")}
    assert [len(people[split]) for split in people] == [8, 2, 2]
    seen = [meshes[0].parent for split in people for meshes in people[split]]
    assert len(set(seen)) == 12
    assert all(len(meshes) == 2 for split in people for meshes in people[split])


@pytest.mark.parametrize("damage", ["metres", "no labels", "no albedo", "bad label", "cut", "no uv", "nobody", "nan"])
def test_what_is_no_scan_is_an_input_error(tmp_path, damage):
    folder = tmp_path / "anna"
    write_scan(folder, size_cm=0.2 if damage == "metres" else 20)
    mesh = folder / "neutral.obj"
    text = mesh.read_text()
    if damage == "no labels":
        (folder / "neutral.labels.png").unlink()
    elif damage == "no albedo":
        (folder / "neutral.albedo.png").unlink()
    elif damage == "bad label":
        Image.fromarray(np.full((8, 8), 77, np.uint8)).save(folder / "neutral.labels.png")
    elif damage == "nobody":
        Image.fromarray(np.full((8, 8), HAIR, np.uint8)).save(folder / "neutral.labels.png")
    elif damage == "cut":
        mesh.write_text(text[:100])
    elif damage == "no uv":
        mesh.write_text(text.replace("vt", "vn"))
    elif damage == "nan":
        mesh.write_text(text.replace("50", "nan"))
    with pytest.raises(InputError, match="anna"):
        read_scan(mesh)


def test_a_folder_without_scans_or_with_a_wardrobe_is_refused(tmp_path):
    with pytest.raises(InputError, match="no scans"):
        load_casting(tmp_path, None)
    write_scan(tmp_path / "anna")
    with pytest.raises(InputError, match="wardrobe"):
        load_casting(tmp_path, tmp_path)
    with pytest.raises(InputError, match="too few people"):
        people_of(tmp_path, "test")


def test_heads_of_a_folder_stay_with_the_people_they_were_split_among(tmp_path):
    for number in range(6):
        write_scan(tmp_path / "scans" / f"person {number}")
    casting = load_casting(tmp_path / "scans", None)
    assert list(bake_missing(casting, tmp_path / "heads", range(0))) == []
    assert list(bake_missing(casting, tmp_path / "heads", range(0))) == []
    write_scan(tmp_path / "scans" / "one more")
    with pytest.raises(InputError, match="other people"):
        list(bake_missing(casting, tmp_path / "heads", range(0)))
    assert list(bake_missing(casting, tmp_path / "new heads", range(0))) == []


def test_a_scan_keeps_its_own_albedo():
    head = ball(16)
    own = np.random.default_rng(0).uniform(0.1, 0.6, (len(head.normal), 3)).astype(np.float32)
    scanned = type(head)(**{**head.__dict__, "albedo": own})
    pool = TexturePool(np.random.default_rng(0), count=2)
    for seed in range(6):
        ratio = paint(scanned, pool, np.random.default_rng(seed), wild=False) / own
        np.testing.assert_allclose(ratio, np.broadcast_to(ratio.mean(0), ratio.shape), rtol=1e-3)


def test_scans_are_baked(tmp_path):
    pytest.importorskip("mitsuba")
    write_scan(tmp_path / "scans" / "anna")
    casting = load_casting(tmp_path / "scans", None)
    assert isinstance(casting, ScanCasting)
    try:
        paths = list(bake_missing(casting, tmp_path / "heads", range(2), 32))
    except (InputError, RuntimeError, ImportError) as error:
        pytest.skip(f"no ray caster here ({error})")
    head = read_shard(paths[0])
    assert {SKIN, HAIR} <= set(np.unique(head.label).tolist())
    np.testing.assert_allclose(head.albedo.mean(0), (np.array([200, 120, 80]) / 255) ** 2.2, atol=0.02)


def test_heads_stay_of_the_same_people_even_where_a_name_is_no_text(tmp_path, monkeypatch):
    scans, heads = ScanCasting(tmp_path), tmp_path / "heads"
    heads.mkdir()
    monkeypatch.setattr(recipe, "names_of_people", lambda folder: ["anna", "m\udcffe"])
    for _ in range(2):
        scans.keep_to_people(heads)
    monkeypatch.setattr(recipe, "names_of_people", lambda folder: ["anna"])
    with pytest.raises(InputError, match="of other people"):
        scans.keep_to_people(heads)
