"""A photo as the halves that a texture takes."""

import tracemalloc

import numpy as np

from app.engine.screen import radiance_for_screen


def test_a_large_photo_is_made_ready_without_another_copy_of_it():
    linear = np.full((1030, 700, 3), 0.25, np.float32)
    linear[1029] = 1e9
    tracemalloc.start()
    screen = radiance_for_screen(linear)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < linear.nbytes, "the halves take half of that"
    assert (screen.dtype, screen.shape) == (np.float16, linear.shape)
    assert (screen[:1029] == 0.25).all()
    assert (screen[1029] == 65504.0).all()
