"""When a viewport that the processor draws is drawn finely."""

from __future__ import annotations

_STILL_FRAMES = 8
"""Frames that have asked for the same: about a quarter of a second."""

MOST_FINE_PIXELS = 1_000_000
"""More of them would take the processor a quarter of a second and longer, in which the window would hear nobody."""


class Finish:
    """Waits until one thing no longer follows another, since drawing finely takes three times as long.

    Attributes:
        is_due: the viewport has something to gain that it has not been given yet.
    """

    def __init__(self) -> None:
        self._asked: object = None
        self._frames = 0
        self.is_due = False

    def has_come(self, asked: object, gains: bool) -> bool:
        """Whether to draw finely now; once a frame.

        Args:
            asked: all that decides what the viewport looks like.
            gains: it would look other than it does.
        """
        self._frames = self._frames + 1 if asked == self._asked else 0
        self._asked = asked
        is_still = self._frames >= _STILL_FRAMES
        self.is_due = gains and not is_still
        return gains and is_still
