"""Resampling between a crop, a picture of the whole photo, and another crop.

A crop's map covers the crop's square, a photo's map the whole photo, both at any resolution. Whole pictures are made
in bands of rows, and a pixel's value doesn't depend on how they are divided into bands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.imaging.ramp import smooth_ramp

_WIDTH_OF_BEYOND = 4.0
"""A view fades toward an edge over at most so many times the width of the photo that lies beyond that edge."""


@dataclass(frozen=True)
class Band:
    """A band of rows of a picture, which may be a smaller copy of the photo.

    Attributes:
        top, bottom: first row of the picture, and the one after the last.
        size: (height, width) of the picture.
        photo_size: (height, width) of the photo.
        columns: first column and the one after the last; None for all.
        step: only every `step`-th row from `top` on.
    """

    top: int
    bottom: int
    size: tuple[int, int]
    photo_size: tuple[int, int]
    columns: tuple[int, int] | None = None
    step: int = 1

    @property
    def span(self) -> tuple[int, int]:
        """First column and the one after the last."""
        return self.columns or (0, self.size[1])

    @property
    def rows(self) -> slice:
        """The band in an array of the picture's size."""
        return slice(self.top, self.bottom, self.step)

    @property
    def pixels(self) -> tuple[slice, slice]:
        """The band's rows and columns in an array of the picture's size."""
        return self.rows, slice(*self.span)

    def part(self, rows: slice, columns: slice) -> Band:
        """A part of the band: some of its rows and columns, counted from its first ones."""
        top, left = self.top + rows.start * self.step, self.span[0]
        bottom = min(self.top + (rows.stop - 1) * self.step + 1, self.bottom)
        return replace(self, top=top, bottom=bottom, columns=(left + columns.start, left + columns.stop))


def bands(size: tuple[int, int], photo_size: tuple[int, int], rows: int = 64) -> list[Band]:
    """A picture divided into bands of at most `rows` rows."""
    return [Band(top, min(top + rows, size[0]), size, photo_size) for top in range(0, size[0], rows)]


def all_of(size: tuple[int, int], photo_size: tuple[int, int]) -> Band:
    """A whole picture as one band."""
    return Band(0, size[0], size, photo_size)


def whole_photo(photo_size: tuple[int, int]) -> tuple[float, float, float, float]:
    """The window x0, y0, x1, y1 that is the whole photo."""
    return 0.0, 0.0, float(photo_size[1]), float(photo_size[0])


def window_of(crop: Crop, photo_size: tuple[int, int], size: tuple[int, int]) -> tuple[slice, slice]:
    """Rows and columns, in a copy (h, w) of the photo, of the upright box around a crop, clipped to the copy.

    Args:
        photo_size: (height, width).
        size: (h, w).
    """
    corners = crop.to_photo(np.array([[0, 0], [0, 1], [1, 0], [1, 1]]), 1) * (np.array(size) / photo_size)[::-1]
    start, end = np.clip(np.round([corners.min(0), corners.max(0)]), 0, size[::-1]).astype(int)
    return slice(start[1], end[1]), slice(start[0], end[0])


def spread_window(maps: np.ndarray, window: tuple[float, float, float, float], band: Band) -> np.ndarray:
    """Maps that cover a window of the photo, resampled bilinearly at every pixel of a band; edges are replicated.

    The window is rounded to whole pixels of the picture.

    Args:
        maps: (h, w) or (h, w, C).
        window: x0, y0, x1, y1 in photo pixels.

    Returns:
        (rows, columns) or (rows, columns, C) float32.
    """
    x0, y0, x1, y1 = _on_pixels(window, band.size, band.photo_size)
    maps = np.ascontiguousarray(maps, np.float32)
    place = np.clip(
        (np.arange(band.top, band.bottom, band.step) + 0.5 - y0) * (len(maps) / (y1 - y0)) - 0.5, 0, len(maps) - 1
    )
    upper = np.floor(place).astype(np.intp)
    share = (place - upper).astype(np.float32).reshape(-1, *[1] * (maps.ndim - 1))
    rows = maps[upper] * (1 - share) + maps[np.minimum(upper + 1, len(maps) - 1)] * share
    wide = cv2.resize(np.ascontiguousarray(rows), (x1 - x0, len(rows)), interpolation=cv2.INTER_LINEAR)
    wide = wide.reshape(len(rows), x1 - x0, *maps.shape[2:])
    first, last = band.span
    if x0 <= first and last <= x1:
        return wide[:, first - x0 : last - x0]
    columns = np.clip(np.arange(first, last) - x0, 0, x1 - x0 - 1)
    inside = slice(max(x0, first), max(min(x1, last), first))
    if inside.start >= inside.stop:
        return wide[:, columns]
    result = np.empty((len(rows), last - first, *maps.shape[2:]), np.float32)
    before, after = inside.start - first, inside.stop - first
    result[:, before:after] = wide[:, inside.start - x0 : inside.stop - x0]
    result[:, :before] = wide[:, columns[:before]]
    result[:, after:] = wide[:, columns[after:]]
    return result


def spread_crop(maps: np.ndarray, crop: Crop, band: Band) -> np.ndarray:
    """Maps (s, s, C) of a crop, resampled bilinearly at every pixel of a band; edges are replicated.

    Returns:
        (rows, columns, C) float32.
    """
    if crop.roll_deg == 0:
        return spread_window(maps, crop.window, band)
    matrix = crop.from_photo_matrix(maps.shape[0])
    step = np.array([band.photo_size[1] / band.size[1], band.photo_size[0] / band.size[0]])
    linear = matrix[:, :2] * step
    offset = linear @ np.array([0.5, band.top + 0.5]) + matrix[:, 2] - 0.5
    linear[:, 1] *= band.step
    wide = cv2.warpAffine(
        np.ascontiguousarray(maps, np.float32),
        np.column_stack([linear, offset]),
        (band.size[1], len(range(band.top, band.bottom, band.step))),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    # OpenCV rounds positions to fractions of a pixel, counted from the first column. So all columns are made and then
    # cut, so that a pixel is the same in every band.
    return wide[:, slice(*band.span)]


def unit_matrix(crop: Crop, size: tuple[int, int], photo_size: tuple[int, int]) -> np.ndarray:
    """(2, 3) affine map from pixel positions in a picture of the photo to [0, 1] across and down a crop.

    It agrees with `spread_crop`, so the window is rounded to pixels of the picture.
    """
    if crop.roll_deg == 0:
        x0, y0, x1, y1 = _on_pixels(crop.window, size, photo_size)
        return np.array([[1 / (x1 - x0), 0, -x0 / (x1 - x0)], [0, 1 / (y1 - y0), -y0 / (y1 - y0)]])
    matrix = crop.from_photo_matrix(1)
    return matrix * np.array([photo_size[1] / size[1], photo_size[0] / size[0], 1.0])


def update_nearest(view: Crop, band: Band, nearest: np.ndarray) -> np.ndarray:
    """Find the pixels of a band that are nearer to the centre of this view than to that of any view before.

    Args:
        nearest: (h, w) float32, the Chebyshev distance to the nearest centre so far, in sides of its view; updated in
            place.

    Returns:
        (h, w) bool.
    """
    matrix = unit_matrix(view, band.size, band.photo_size)
    y = np.arange(band.top, band.bottom, band.step, dtype=np.float64)[:, None] + 0.5
    x = np.arange(*band.span, dtype=np.float64)[None, :] + 0.5
    if view.roll_deg == 0:
        places = matrix[0, 0] * x + matrix[0, 2], matrix[1, 1] * y + matrix[1, 2]
    else:
        places = tuple(row[0] * x + row[1] * y + row[2] for row in matrix)
    distance = np.maximum(*(np.abs(place - 0.5).astype(np.float32) for place in places))
    is_nearer = distance < nearest
    np.copyto(nearest, distance, where=is_nearer)
    return is_nearer


def seen_across(view: Crop, size: int, maps: np.ndarray, other: Crop, into: np.ndarray | None = None) -> np.ndarray:
    """Another view's maps (s, s, C), resampled bilinearly onto a view's grid, (size, size, C); edges are replicated.

    Args:
        view, other: where in the photo the result and the maps lie.
        into: float32 array of the result's shape, to be filled instead of a new one.
    """
    matrix = _square(other.from_photo_matrix(maps.shape[0])) @ _square(_to_photo(view, size))
    return _looked_up(maps, matrix, size, into)


def seen_from(
    view: Crop, size: int, maps: np.ndarray, photo_size: tuple[int, int], into: np.ndarray | None = None
) -> np.ndarray:
    """Maps over the whole photo, (h, w) or (h, w, C), resampled bilinearly onto a view's grid of size x size.

    Args:
        photo_size: (height, width).
        into: as of `seen_across`.
    """
    to_maps = np.diag([maps.shape[1] / photo_size[1], maps.shape[0] / photo_size[0], 1.0])
    return _looked_up(maps, to_maps @ _square(_to_photo(view, size)), size, into)


def places_of(size: tuple[int, int], extent: tuple[int, int]) -> np.ndarray:
    """(h, w, 2) x and y of the centres of the cells of a grid.

    Args:
        size: (h, w), the grid's.
        extent: (height, width) of the area that it covers, in the units of the positions.
    """
    y, x = ((np.arange(count) + 0.5) * length / count for count, length in zip(size, extent, strict=True))
    return np.stack(np.meshgrid(x, y), axis=-1)


def across_and_down(crop: Crop, size: tuple[int, int], photo_size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Positions across and down a crop, in sides of it, of the cell centres of a grid over the photo, (h, w) each.

    Args:
        size: (h, w), the grid's.
        photo_size: (height, width).
    """
    x, y = ((np.arange(few) + 0.5) * many / few for few, many in zip(size[::-1], photo_size[::-1], strict=True))
    (x_across, y_across, left), (x_down, y_down, top) = crop.from_photo_matrix(1)
    return x_across * x + (y_across * y + left)[:, None], x_down * x + (y_down * y + top)[:, None]


def fade(position: np.ndarray, width: float, before: float = np.inf, after: float = np.inf) -> np.ndarray:
    """Weights of a view along an axis: 1 inside, falling smoothly to 0 over `width` toward both ends of [0, 1].

    Args:
        position: of any shape; the view is [0, 1].
        width: of the fade, in units of the position.
        before, after: how much of the photo lies beyond the low and the high end, in the same units. An end fades over
            at most four times that: if a single pixel lies beyond it, hardly at all, and if nothing does, not at all.

    Returns:
        float32 of the position's shape, in [0, 1].
    """
    position, result = np.asarray(position), np.ones(np.shape(position))
    for inward, beyond in ((position, before), (1.0 - position, after)):
        if beyond > 0:
            result = np.minimum(result, smooth_ramp(inward, 0.0, min(width, _WIDTH_OF_BEYOND * beyond)))
    return result.astype(np.float32)


def _on_pixels(
    window: tuple[float, float, float, float], size: tuple[int, int], photo_size: tuple[int, int]
) -> tuple[int, int, int, int]:
    """A window of the photo in whole pixels of a picture of it: x0, y0, x1, y1."""
    along_y, along_x = size[0] / photo_size[0], size[1] / photo_size[1]
    y0, y1 = _whole(window[1] * along_y, window[3] * along_y)
    x0, x1 = _whole(window[0] * along_x, window[2] * along_x)
    return x0, y0, x1, y1


def _whole(low: float, high: float) -> tuple[int, int]:
    """An interval rounded to whole pixels, at least one long."""
    first = round(low)
    return first, max(round(high), first + 1)


def _looked_up(maps: np.ndarray, matrix: np.ndarray, size: int, into: np.ndarray | None) -> np.ndarray:
    """Maps resampled on a size x size grid; the (3, 3) matrix maps the grid to the maps, both in pixel edges."""
    centred = matrix[:2].copy()
    centred[:, 2] += centred[:, :2] @ [0.5, 0.5] - 0.5
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    source = np.ascontiguousarray(maps, np.float32)
    return cv2.warpAffine(source, centred, (size, size), dst=into, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def _to_photo(view: Crop, size: int) -> np.ndarray:
    """(2, 3) affine map from positions in a view of size x size to the photo."""
    return cv2.invertAffineTransform(view.from_photo_matrix(size))


def _square(matrix: np.ndarray) -> np.ndarray:
    """A (2, 3) affine map as a (3, 3) matrix, which can be multiplied."""
    return np.vstack([matrix, [0.0, 0.0, 1.0]])
