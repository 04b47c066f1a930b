"""A film of sRGB frames that browsers, phones and editors play in the same colours."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from relight_core.errors import InputError
from relight_core.imaging.files import whole_file

FRAMES_PER_SECOND = 24
_CODEC = "libx264"
_OPTIONS = {"crf": "16", "preset": "veryfast"}
"""Hard to tell from the frames; a slower preset makes the file 7 % smaller in more than twice the time."""

_BT709, _SRGB_CURVE, _LIMITED_RANGE = 1, 13, 1
"""As ITU-T H.273 and FFmpeg number them. Players guess what a film doesn't say, and guess by its size."""


def write_film(path: Path, frames: Iterator[np.ndarray], count: int, step: Callable[[int, int], None]) -> None:
    """Write an MP4 (H.264, BT.709 with the sRGB curve), whole or not at all; replaces what is there.

    Args:
        frames: (H, W, 3) uint8 sRGB each, all of one size, height and width even.
        count: how many there are.
        step: told after each how many are done, and `count`; what it raises ends the work.

    Raises:
        InputError: there is no codec for it, or the place can't be written.
    """
    import av

    with whole_file(path, ".mp4") as beside:
        try:
            _encode(beside, frames, count, step)
        except av.codec.codec.UnknownCodecError:
            raise InputError(
                f"{path}: there is no codec for MP4 here; export the turntable as pictures instead"
            ) from None
        except av.FFmpegError as error:
            raise InputError(f"{path}: the film can't be written ({error.strerror}); choose another place") from error


def _encode(path: Path, frames: Iterator[np.ndarray], count: int, step: Callable[[int, int], None]) -> None:
    import av
    from av.video.reformatter import ColorRange, Colorspace

    with av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"}) as film:
        stream = film.add_stream(_CODEC, rate=FRAMES_PER_SECOND, options=_OPTIONS)
        stream.pix_fmt = "yuv420p"
        coded = stream.codec_context
        coded.colorspace = coded.color_primaries = _BT709
        coded.color_trc, coded.color_range = _SRGB_CURVE, _LIMITED_RANGE
        # Relighting takes longer than this, and the window draws on a core of its own.
        coded.thread_count = 1
        for index, frame in enumerate(frames):
            if index == 0:
                stream.height, stream.width = frame.shape[:2]
            picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), "rgb24").reformat(
                format="yuv420p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
            )
            film.mux(stream.encode(picture))
            step(index + 1, count)
        film.mux(stream.encode())
