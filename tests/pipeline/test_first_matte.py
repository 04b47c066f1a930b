"""The matte whose edges are still coarse: what it decides about, and a picture that begins elsewhere."""

import numpy as np
import pytest

from relight_core.face.crop import Crop
from relight_core.pipeline.per_photo.first_matte import SeenPeople, first_matte, first_matte_within

SIZE = 160
RED, GREEN, BLUE = (0.7, 0.3, 0.25), (0.3, 0.45, 0.2), (0.2, 0.3, 0.6)


def somebody_by_a_trunk(likely):
    """A guide and a look at somebody who leans on a trunk that is a person as likely as that."""
    y, x = np.mgrid[:SIZE, :SIZE] + 0.5
    person = (np.hypot(x - 80, y - 60) < 30) | (y > 85) & (np.abs(x - 80) < 40)
    person |= (y > 120) & (y < 135) & (x > 80) & (x < 121)
    trunk = (x > 120) & (x < 140) & (y > 60)
    guide = np.where(person[..., None], RED, np.where(trunk[..., None], GREEN, BLUE)).astype(np.float32)
    return guide, np.where(person, 1.0, likely * trunk).astype(np.float32)


@pytest.mark.parametrize(("likely", "least", "most"), [(0.4, 0.0, 0.03), (0.7, 0.97, 1.0)])
def test_what_is_evenly_half_and_half_becomes_what_is_likelier(likely, least, most):
    guide, mask = somebody_by_a_trunk(likely)
    matte = first_matte(guide, SeenPeople([[(mask, Crop(80.0, 80.0, 160.0))]]), (SIZE, SIZE))
    assert least <= matte[70:110, 124:136].min() <= matte[70:110, 124:136].max() <= most
    assert matte[40:80, 70:90].min() > 0.99
    assert matte[:20].max() < 0.01


def test_all_looks_move_with_a_photo_that_begins_elsewhere():
    mask, view = np.ones((4, 4), np.float32), Crop(50.0, 60.0, 30.0, 20.0)
    look = (mask, view)
    moved = SeenPeople([[look, look], [look]], [look], [[look]]).moved(-10.0, 5.0)
    for looks in (*moved.people, moved.faces, *moved.others):
        assert [at for _, at in looks] == [Crop(40.0, 65.0, 30.0, 20.0)] * len(looks)
        assert all(seen is mask for seen, _ in looks)
    assert [len(looks) for looks in moved.people] == [2, 1]
    assert (len(moved.faces), len(moved.others)) == (1, 1)


def test_within_a_frame_the_matte_is_that_of_the_picture_alone_and_its_edges_go_on_around_it():
    guide, mask = somebody_by_a_trunk(0.0)
    alone = first_matte(guide, SeenPeople([[(mask, Crop(80.0, 80.0, 160.0))]]), (SIZE, SIZE))
    framed = np.full((220, 230, 3), 0.9, np.float32)
    cells = np.s_[20 : 20 + SIZE, 40 : 40 + SIZE]
    framed[cells] = guide
    seen = SeenPeople([[(mask, Crop(80.0 + 40, 80.0 + 20, 160.0))]])
    matte = first_matte_within(cells, framed, seen, (220, 230))
    np.testing.assert_allclose(matte[cells], alone, atol=1e-5)
    np.testing.assert_allclose(matte[200:, 80:160], np.broadcast_to(alone[-1, 40:120], (20, 80)), atol=0.05)


def test_who_is_known_not_to_be_meant_is_left_out_of_whoever_is_beside_them():
    guide, everybody = somebody_by_a_trunk(1.0)
    _, somebody = somebody_by_a_trunk(0.0)
    view, whole = Crop(95.0, 85.0, 100.0), Crop(80.0, 80.0, 160.0)
    people = [[(view.extract(everybody, 160), view)]]
    others = [[(everybody - somebody, whole)]]
    both, one = (first_matte(guide, SeenPeople(people, (), them), (SIZE, SIZE)) for them in ((), others))
    assert both[70:110, 124:136].min() > 0.9
    assert one[70:110, 124:136].max() < 0.2
    assert min(both[60, 80], one[60, 80]) > 0.9
