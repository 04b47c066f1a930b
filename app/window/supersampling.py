"""When a viewport that is drawn in software is supersampled: once it has stopped changing."""

from __future__ import annotations

_STILL_FRAMES = 8
"""Frames in a row that have asked for the same picture: about a quarter of a second."""

MOST_SUPERSAMPLED_PIXELS = 1_000_000
"""More would keep the processor busy for a quarter of a second or longer, and the window would not react meanwhile."""


class SupersamplingDelay:
    """Holds supersampling back while the viewport still changes, since it takes three times as long to draw.

    Attributes:
        is_pending: the viewport would look better supersampled and has not been drawn so yet.
    """

    def __init__(self) -> None:
        self._asked: object = None
        self._frames = 0
        self.is_pending = False

    def is_over(self, asked: object, gains: bool) -> bool:
        """Whether to supersample this frame; called once a frame.

        Args:
            asked: everything that decides what the viewport looks like.
            gains: supersampling would make it look different.
        """
        self._frames = self._frames + 1 if asked == self._asked else 0
        self._asked = asked
        is_still = self._frames >= _STILL_FRAMES
        self.is_pending = gains and not is_still
        return gains and is_still
