"""Names of files as they can be drawn."""

import re

_NO_TEXT = re.compile("[\ud800-\udfff]")


def legible(text: str) -> str:
    """The text with a replacement character for all that is no text, such as odd bytes in the name of a file."""
    return _NO_TEXT.sub("\N{REPLACEMENT CHARACTER}", text)
