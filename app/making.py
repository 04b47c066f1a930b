"""Makes the Relighter that the command line and the window work with."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from relight_core.pipeline.relighter import Relighter


def make_relighter() -> Relighter:
    """The Relighter with the bundled weights, for the calling thread; loading it takes seconds."""
    from app.engine.pace import leave_a_core
    from relight_core.pipeline.relighter import Relighter

    leave_a_core()
    return Relighter()
