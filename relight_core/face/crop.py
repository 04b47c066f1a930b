"""The square around a face that the networks see, and where it lies in the photo."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from relight_core.face.find import FaceBox
from relight_core.face.parsing import FACE_LABELS
from relight_core.imaging.masks import largest_part
from relight_core.imaging.resampling import resample_window, resize_area

FOREHEAD = 0.25
"""Height of the forehead, from brows to hairline, as a fraction of a face's height from brow to chin."""

PADDING_PX, PADDED_PX = 30.0, 256.0
"""Margin between a face and the edges of the paper's crop, and that crop's side; the paper draws the margin from 20 to
40 (section 3.2)."""

_SMALLEST_FACE_SHARE, _HALF = 0.01, 0.5
"""A face covers at least this share of its crop; pixels with at least this probability belong to it."""
_DIAGONAL = 2**0.5
"""Of a square, in sides."""


@dataclass(frozen=True)
class Crop:
    """A square window of a photo, which may reach beyond the photo and may be rotated about its centre.

    Positions in the photo and in the crop are in pixel edges: pixel i spans i to i + 1.

    Attributes:
        centre_x, centre_y: its centre, in photo pixels.
        side: its width and height, in photo pixels, > 0.
        roll_deg: its counterclockwise rotation, as seen on the photo. A head that leans to the left of the photo has
            a positive roll, and is upright in its crop.

    Raises:
        ValueError: a side that is not positive and finite.
    """

    centre_x: float
    centre_y: float
    side: float
    roll_deg: float = 0.0

    def __post_init__(self) -> None:
        if not (self.side > 0.0 and np.isfinite([self.centre_x, self.centre_y, self.side, self.roll_deg]).all()):
            raise ValueError(f"a crop has a finite centre and a positive side, not {self}")

    @property
    def window(self) -> tuple[float, float, float, float]:
        """x0, y0, x1, y1 in photo pixels, before the rotation."""
        half = self.side / 2.0
        return self.centre_x - half, self.centre_y - half, self.centre_x + half, self.centre_y + half

    def moved(self, right: float, down: float) -> Crop:
        """The window shifted, or with its position counted from another origin."""
        return replace(self, centre_x=self.centre_x + right, centre_y=self.centre_y + down)

    def extract(self, image: np.ndarray, size: int) -> np.ndarray:
        """Resample the window to size x size pixels.

        Shrinking averages areas exactly, enlarging is Catmull-Rom. Outside the photo its edge pixels are repeated.

        Args:
            image: (H, W) or (H, W, C); colours must be linear, since they are averaged.
            size: pixels along a side of the result.

        Returns:
            (size, size) or (size, size, C) float32.
        """
        if self.roll_deg == 0:
            return resample_window(image, self.window, (size, size))
        return self._extract_turned(image, size)

    def to_photo(self, points: np.ndarray, size: int) -> np.ndarray:
        """Positions in the photo of points (..., 2), x and y in the size x size crop."""
        return _mapped(points, cv2.invertAffineTransform(self.from_photo_matrix(size)))

    def from_photo(self, points: np.ndarray, size: int) -> np.ndarray:
        """Positions in the size x size crop of points (..., 2), x and y in the photo."""
        return _mapped(points, self.from_photo_matrix(size))

    def from_photo_matrix(self, size: int) -> np.ndarray:
        """(2, 3) affine map from photo positions to positions in the size x size crop."""
        turn = axes_in_photo(self.roll_deg) * (size / self.side)
        return np.column_stack([turn, size / 2 - turn @ [self.centre_x, self.centre_y]])

    def _extract_turned(self, image: np.ndarray, size: int) -> np.ndarray:
        """The rotated window, resampled from an upright one around it at twice the resolution and then shrunk."""
        around = replace(self, side=self.side * _DIAGONAL, roll_deg=0.0)
        fine = max(round(2 * size * _DIAGONAL), 1)
        matrix = self.from_photo_matrix(2 * size)
        corner, step = np.array(around.window[:2]), around.side / fine
        linear = matrix[:, :2] * step
        offset = matrix[:, :2] @ corner + matrix[:, 2] + linear @ [0.5, 0.5] - 0.5
        turned = cv2.warpAffine(
            around.extract(image, fine),
            np.column_stack([linear, offset]),
            (2 * size, 2 * size),
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return resize_area(turned, (size, size))


def axes_in_photo(roll_deg: float) -> np.ndarray:
    """(2, 2) unit vectors in the photo: the right and the down direction of a view rotated by `Crop.roll_deg`."""
    angle = np.radians(roll_deg)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _mapped(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Points (..., 2) through a (2, 3) affine map. OpenCV, since NumPy's product takes ten times as long."""
    points = np.asarray(points, np.float64)
    return cv2.transform(points.reshape(1, -1, 2), matrix).reshape(points.shape) if points.size else points


def crop_for_face(box: FaceBox) -> Crop:
    """The first crop around a detected face: forehead to chin, however it leans, with the paper's margin.

    Once its parsing is known, `box_from_parsing` and `crop_with_padding` refine it.
    """
    roll, half = np.radians(box.roll_deg), FOREHEAD * box.height / 2
    left, up, down = half * np.sin(roll), half * (1 + np.cos(roll)), half * (1 - np.cos(roll))
    whole = FaceBox(box.x0 - left, box.y0 - up, box.x1 - left, box.y1 + down, box.roll_deg)
    return crop_with_padding(whole)


def crop_with_padding(box: FaceBox) -> Crop:
    """The square around the box of a whole face in which the box's longer side has the paper's margin.

    Its edges are on whole pixels, so that extracting it at its own size copies the photo's pixels.
    """
    side = float(max(round(max(box.width, box.height) * PADDED_PX / (PADDED_PX - 2 * PADDING_PX)), 1))
    x0 = float(round((box.x0 + box.x1 - side) / 2.0))
    y0 = float(round((box.y0 + box.y1 - side) / 2.0))
    return Crop(x0 + side / 2.0, y0 + side / 2.0, side, box.roll_deg)


def box_from_parsing(parsing: np.ndarray, crop: Crop) -> FaceBox | None:
    """The bounding box of the face's regions in a parsing map (paper, section 3.2), in photo pixels.

    Only the largest connected part counts, so specks don't. The box has the crop's roll. Its edges are found with
    subpixel precision: on whole pixels, of 1/128 of the view, the framing would jump after a tiny change of exposure.

    Args:
        parsing: (classes, S, S) probabilities, in the order of `relight_core.face.parsing.CLASSES`.
        crop: where the map lies in the photo.

    Returns:
        None if less than 1 % of the crop is face.
    """
    share = parsing[list(FACE_LABELS)].sum(0).astype(np.float32)
    share = cv2.morphologyEx(share, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    largest = largest_part(share > _HALF, _SMALLEST_FACE_SHARE * share.size)
    if largest is None:
        return None
    # One pixel more than the part itself, for the subpixel edges; no other part is that near.
    own = share * cv2.dilate(largest, np.ones((3, 3), np.uint8))
    (left, right), (top, bottom) = _span(own.max(0)), _span(own.max(1))
    middle_x, middle_y = crop.to_photo(np.array([left + right, top + bottom]) / 2, len(share))
    scale = crop.side / len(share)
    half_x, half_y = (right - left) * scale / 2, (bottom - top) * scale / 2
    sides = (middle_x - half_x, middle_y - half_y, middle_x + half_x, middle_y + half_y)
    return FaceBox(*(float(side) for side in sides), crop.roll_deg)


def _span(share: np.ndarray) -> tuple[float, float]:
    """Where shares (S,) first rise above one half and last fall below it, in pixel edges; some must be above.

    Shares are samples at pixel centres, with linear interpolation between them. A face that reaches the border of the
    map ends there.
    """
    first, last = np.flatnonzero(share > _HALF)[[0, -1]]

    def beyond(inner: int, outer: int) -> float:
        if not 0 <= outer < len(share):
            return 0.0
        return float((share[inner] - _HALF) / (share[inner] - share[outer])) - 0.5

    return first - beyond(first, first - 1), last + 1 + beyond(last, last + 1)
