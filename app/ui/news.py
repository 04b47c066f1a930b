"""How long a line for the user stays in sight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from app.ui.state import EditorState

_GOOD_NEWS_S = 8.0
"""Long enough to read where a picture was saved."""

_LONGEST_FRAME_S = 0.25
"""A window at rest draws none: nobody need have been there to read."""


@dataclass
class News:
    """The newest line that reports no error.

    Attributes:
        number: the message's.
        seen_s: how long it has been in sight of a window that is used.
        frame_s: when the last frame was.
    """

    number: int = 0
    seen_s: float = 0.0
    frame_s: float = 0.0


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
        state.news = News(message.number, 0.0, now_s)
        return
    news.seen_s += min(now_s - news.frame_s, _LONGEST_FRAME_S)
    news.frame_s = now_s
    if news.seen_s > _GOOD_NEWS_S:
        state.dismissed = message.number
