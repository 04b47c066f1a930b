"""How long a line for the user stays in sight."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from app.engine.snapshot import Message, Snapshot

if TYPE_CHECKING:
    from app.ui.state import EditorState

_GOOD_NEWS_S = 8.0
"""Long enough to read where a picture was saved."""

_LONGEST_FRAME_S = 0.25
"""A window at rest draws none: nobody need have been there to read."""


@dataclass
class News:
    """What has been read of the lines for the user.

    Attributes:
        number: of the newest one that reports no error.
        seen_s: how long that has been in sight of a window that is used.
        frame_s: when the last frame was.
        put_away: numbers of those that are not to be shown again.
    """

    number: int = 0
    seen_s: float = 0.0
    frame_s: float = 0.0
    put_away: set[int] = field(default_factory=set)

    def in_sight(self, snapshot: Snapshot) -> Message | None:
        """The newest line that was not put away: what was said last, or else an error that was said before."""
        said = *snapshot.errors, *([snapshot.message] if snapshot.message else [])
        left = [message for message in said if message.number not in self.put_away]
        return max(left, key=lambda message: message.number, default=None)


def put_message_away(state: EditorState) -> None:
    """Show the line in sight no more; an error that it has covered is in sight again."""
    if (message := state.message()) is not None:
        state.news.put_away.add(message.number)


def let_news_pass(state: EditorState, now_s: float) -> None:
    """Put a line away that reports no error, once it has been read; an error stays until the user puts it away.

    Once for each frame that was drawn.

    Args:
        now_s: a clock that never goes back.
    """
    message, news = state.message(), state.news
    if message is None or message.is_error:
        return
    if news.number != message.number:
        news.number, news.seen_s, news.frame_s = message.number, 0.0, now_s
        return
    news.seen_s += min(now_s - news.frame_s, _LONGEST_FRAME_S)
    news.frame_s = now_s
    if news.seen_s > _GOOD_NEWS_S:
        put_message_away(state)
