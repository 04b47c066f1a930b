"""The finished picture, a band of rows at a time: every pixel is a function of the photo's own and of small maps.

So a picture of any size, a preview of the screen's size, and a file too large to hold twice in memory are
all the same computation, and how it is cut changes nothing. `pipeline.results.display` hands the same maps to a shader.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from relight_core.face.crop import Crop
from relight_core.face.paste import Band, bands, spread_crop, spread_window, update_nearest, whole_photo
from relight_core.imaging.in_order import in_order
from relight_core.imaging.masks import bounds
from relight_core.imaging.photo import with_black, without_black
from relight_core.imaging.resampling import resize_area
from relight_core.pipeline.per_photo.matte import Matte
from relight_core.pipeline.per_photo.person import Canvas, Person, person_in
from relight_core.pipeline.results.backdrop import Backdrop

LENS_VEIL, LIGHT_WRAP, MOST_WRAP = 0.01, 0.5, 0.25
"""How much of a new background's light lies over the person's edge: whatever is there, of what gives it back a share of
its own colour, and at most."""


@dataclass(frozen=True, eq=False)
class PlacedChange:
    """What a light does within the view of one face, all faces and the rest of the person considered.

    Attributes:
        gain, offset: (S, S, 3) float32, at the light's level; toward the view's edges they become those of
            whatever lies beyond, so that views can be laid side by side.
        view: where it lies.
    """

    gain: np.ndarray
    offset: np.ndarray
    view: Crop


@dataclass(frozen=True, eq=False)
class PlacedCatchlight:
    """What a light adds to the relit picture in one eye, or takes from it.

    Attributes:
        added: (E, E, 3) float32 linear, at the light's level; 0 at its border.
        view: where it lies, upright and with edges on whole pixels of the photo.
    """

    added: np.ndarray
    view: Crop

    def to_view(self, photo_size: tuple[int, int]) -> np.ndarray:
        """(2, 3) float64 from places in the picture, [0, 1] across and down, to those in the view.

        Args:
            photo_size: (height, width).
        """
        height, width = photo_size
        return self.view.from_photo_matrix(1) * np.array([width, height, 1.0])

    def within(self, band: Band) -> tuple[tuple[slice, slice], np.ndarray]:
        """What is added in a band of the picture, averaged as the photo's pixels are.

        Returns:
            the band's own rows and columns that it meets, and (h, w, 3) for those; h and w may be 0.
        """
        (height, width), matrix = band.size, self.to_view(band.photo_size)
        size = min(max(round(width / matrix[0, 0]), 1), len(self.added))
        across = matrix[0, 0] * (np.arange(*band.span) + 0.5) / width + matrix[0, 2]
        down = matrix[1, 1] * (np.arange(band.top, band.bottom, band.step) + 0.5) / height + matrix[1, 2]
        columns, rows = (np.flatnonzero((place > 0) & (place < 1)) for place in (across, down))
        if not (rows.size and columns.size):
            return (slice(0), slice(0)), np.empty((0, 0, 3), np.float32)
        part = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        x, y = np.meshgrid(*((place * size - 0.5).astype(np.float32) for place in (across[part[1]], down[part[0]])))
        small = resize_area(self.added, (size, size))
        return part, cv2.remap(small, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


@dataclass(frozen=True, eq=False)
class Picture:
    """A relit picture that is computed where it is asked for.

    Attributes:
        canvas: the photo at the picture's size.
        matte: of the photo.
        changes: one for each face; a place in several views takes the one whose middle is nearest.
        rest: (h, w, 3) gain over the whole photo beyond the views, at the light's level.
        backdrop: what is behind the person.
        person: of the whole canvas, where it is kept; else it is worked out band by band.
        wide: colours outside Rec.709 stay, with values below 0 or above 1; else all are within it, as on a screen.
        exposure: of the portrait; of the photo times this, skin and cloth are as bright as their colours.
        catchlights: what the eyes mirror, on top of the views' changes.
    """

    canvas: Canvas
    matte: Matte
    changes: tuple[PlacedChange, ...]
    rest: np.ndarray
    backdrop: Backdrop
    person: Person | None = field(default=None, repr=False)
    wide: bool = False
    exposure: float = 1.0
    catchlights: tuple[PlacedCatchlight, ...] = ()

    @property
    def size(self) -> tuple[int, int]:
        """(height, width)."""
        return self.canvas.size

    @property
    def has_alpha(self) -> bool:
        """Whether the background is taken away."""
        return self.backdrop.transparent

    def render(self) -> tuple[np.ndarray, np.ndarray | None]:
        """All of it: (H, W, 3) float32 linear, and (H, W) alpha or None."""
        return self.part((0, 0, self.size[1], self.size[0]))

    def part(self, window: tuple[int, int, int, int]) -> tuple[np.ndarray, np.ndarray | None]:
        """`render` of a window of the picture alone: x0, y0, x1, y1 in its pixels, the latter two not included."""
        x0, y0, x1, y1 = window
        image = np.empty((y1 - y0, x1 - x0, 3), np.float32)
        alpha = np.empty(image.shape[:2], np.float32) if self.has_alpha else None

        def make(band: Band) -> None:
            rows = slice(band.top, band.bottom)
            placed = replace(band, top=y0 + band.top, bottom=y0 + band.bottom, size=self.size, columns=(x0, x1))
            image[rows], share = self.band(placed)
            if alpha is not None:
                alpha[rows] = share

        for _ in in_order(make, bands(image.shape[:2], self.canvas.photo_size)):
            pass
        return image, alpha

    def in_bands(self, rows: int = 64, *, wide: bool = False) -> Iterator[tuple[slice, np.ndarray, np.ndarray | None]]:
        """Rows, image and alpha of one band after the other, from the top, worked out a little ahead.

        Args:
            wide: colours outside Rec.709 stay, as with the picture's own `wide`.
        """
        picture = replace(self, wide=wide)
        return in_order(lambda band: (band.rows, *picture.band(band)), bands(self.size, self.canvas.photo_size, rows))

    def thinned(self, step: int) -> tuple[np.ndarray, np.ndarray | None]:
        """Every `step`-th row and column of `render`."""
        image, alpha = self.band(Band(0, self.size[0], self.size, self.canvas.photo_size, step=step))
        return image[:, ::step], None if alpha is None else alpha[:, ::step]

    def pixel(self, row: int, column: int) -> tuple[np.ndarray, float]:
        """Radiance (3,) and alpha of one pixel.

        Raises:
            IndexError: it lies outside.
        """
        if not (0 <= row < self.size[0] and 0 <= column < self.size[1]):
            raise IndexError(f"row {row}, column {column} of {self.size}")
        image, alpha = self.band(Band(row, row + 1, self.size, self.canvas.photo_size, (column, column + 1)))
        return image[0, 0], 1.0 if alpha is None else float(alpha[0, 0])

    def band(self, band: Band) -> tuple[np.ndarray, np.ndarray | None]:
        """Some rows: (h, w, 3) float32 linear, and (h, w) alpha or None."""
        person = self._person(band)
        if self.backdrop.kept:
            image = self._beside_the_photo(self.canvas.linear[band.pixels], person, band)
        else:
            image = self._relit(person.colour, band)
            if not self.backdrop.transparent:
                image *= person.share[..., None]
                image += self._behind(person, band)
        if (black := self.canvas.black) is not None:
            image = np.maximum(with_black(image, black), 0)
        if self.wide and self.canvas.beyond is not None:
            self._add_beyond(image, person.share[..., None], band)
        return image, person.share if self.backdrop.transparent else None

    def behind(self, band: Band) -> np.ndarray:
        """What is seen beside the person in some rows, (h, w, 3) float32 linear.

        What `band` has besides is the person's own light, times the matte. Light of a new background that wraps round
        the person's edge counts as background.
        """
        person = self._person(band)
        if self.backdrop.transparent:
            return np.zeros((*person.share.shape, 3), np.float32)
        image = self._behind(person, band)
        if (black := self.canvas.black) is not None:
            image = (1.0 - person.share)[..., None] * black.level + black.left * image
        gain = 1.0 if self.backdrop.kept else self.backdrop.gain
        if self.wide and self.canvas.beyond is not None and gain is not None:
            image += (1.0 - person.share)[..., None] * gain * self.canvas.beyond[band.pixels].astype(np.float32)
        return image

    def _person(self, band: Band) -> Person:
        if self.person is None:
            return person_in(self.canvas, self.matte, band)
        return Person(self.person.share[band.pixels], self.person.colour[band.pixels])

    def _add_beyond(self, image: np.ndarray, share: np.ndarray, band: Band) -> None:
        """Add what of the photo's colours lies outside Rec.709, relit as the rest of each pixel is."""
        beyond = self.canvas.beyond[band.pixels].astype(np.float32)
        if not beyond.any():
            return
        gain = self._relit(np.ones_like(beyond), band, gloss=False)
        if not self.backdrop.transparent:
            behind = 1.0 if self.backdrop.kept else self.backdrop.gain
            gain *= share
            gain += 0.0 if behind is None else (1.0 - share) * behind
        gain *= beyond
        image += gain

    def _beside_the_photo(self, linear: np.ndarray, person: Person, band: Band) -> np.ndarray:
        """The person in the new light before the photo's own background; only the person's columns are computed."""
        result = linear.copy()
        held = np.flatnonzero(person.share.any(axis=0))
        if not held.size:
            return result
        first, last = int(held[0]), int(held[-1]) + 1
        colour, share = person.colour[:, first:last], person.share[:, first:last]
        start = band.span[0]
        relit = self._relit(colour, replace(band, columns=(start + first, start + last)))
        # Repeated by hand: numpy takes five times as long for pixels times shares of pixels.
        shares = cv2.merge((share, share, share)).reshape(relit.shape)
        relit *= shares
        # Apart, as in the shader: a person far darker than the photo would be rounded to steps of the photo's radiance.
        shares *= colour
        relit += np.subtract(linear[:, first:last], shares, out=shares)
        np.maximum(relit, without_black(np.float32(0), self.canvas.black), out=result[:, first:last])
        return result

    def _relit(self, colour: np.ndarray, band: Band, gloss: bool = True) -> np.ndarray:
        """The person's own colour (h, w, 3) in the new light, with or without what that adds to any colour."""
        relit = self._relit_by_views(colour, band, gloss)
        if gloss:
            for catchlight in self.catchlights:
                part, added = catchlight.within(band)
                np.maximum(relit[part] + added, 0, out=relit[part])
        return relit

    def _relit_by_views(self, colour: np.ndarray, band: Band, gloss: bool) -> np.ndarray:
        nearest = np.full(colour.shape[:2], 0.5, np.float32)
        inside = [update_nearest(placed.view, band, nearest) for placed in self.changes]
        if len(inside) == 1 and inside[0].all():
            return self._within(self.changes[0], colour, band, gloss)
        relit = spread_window(self.rest, whole_photo(self.canvas.photo_size), band)
        relit *= colour
        for placed, chosen in zip(self.changes, inside, strict=True):
            part = bounds(chosen)
            if part[0].stop:
                lit = self._within(placed, colour[part], band.part(*part), gloss)
                np.copyto(relit[part], lit, where=chosen[part][..., None])
        return relit

    @staticmethod
    def _within(placed: PlacedChange, colour: np.ndarray, band: Band, gloss: bool) -> np.ndarray:
        relit = spread_crop(placed.gain, placed.view, band)
        relit = relit * colour
        if gloss:
            relit += spread_crop(placed.offset, placed.view, band)
        return relit

    def _behind(self, person: Person, band: Band) -> np.ndarray:
        """What lies behind the person, as far as it is seen; a new background's light wraps round the edge a little."""
        share = person.share[..., None]
        if self.backdrop.picture is None:
            seen = self.canvas.linear[band.pixels] - share * person.colour
            if self.backdrop.kept:
                return np.maximum(seen, without_black(np.float32(0), self.canvas.black))
            return np.maximum(seen, 0.0) * self.backdrop.gain
        everywhere = whole_photo(self.canvas.photo_size)
        picture, soft = (
            spread_window(layer, everywhere, band) if layer.ndim == 3 else layer
            for layer in (self.backdrop.picture, self.backdrop.soft)
        )
        near = share if self.matte.own_alpha else spread_window(self.matte.nearby, everywhere, band)[..., None]
        wrapped = np.minimum(LENS_VEIL + np.float32(LIGHT_WRAP * self.exposure) * person.colour, MOST_WRAP)
        return (1.0 - share) * picture + share * (1.0 - near) * wrapped * soft
