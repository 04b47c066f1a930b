"""Masks: where they lie, how far away, what of them hangs together, and the discs that they are grown and shrunk by."""

from __future__ import annotations

import cv2
import numpy as np


def bounds(mask: np.ndarray) -> tuple[slice, slice]:
    """The rows and columns about all of a mask (h, w) that is true or above 0; none where nothing is."""
    left, top, width, height = cv2.boundingRect((mask > 0).astype(np.uint8))
    return slice(top, top + height), slice(left, left + width)


def largest_part(mask: np.ndarray, fewest_px: float = 1) -> np.ndarray | None:
    """(h, w) uint8, 1 in the largest part of a mask (h, w), bool, that hangs together, corners included.

    None where that has fewer pixels than `fewest_px`.
    """
    count, parts, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    if count < 2:
        return None
    largest = 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax())
    return (parts == largest).astype(np.uint8) if stats[largest, cv2.CC_STAT_AREA] >= fewest_px else None


def part_at(mask: np.ndarray, place: np.ndarray) -> np.ndarray | None:
    """(h, w) bool, the part of a mask that hangs together, corners included, and that most of a place lies in.

    None where they have no pixel in common.

    Args:
        mask, place: (h, w), bool.
    """
    _, parts = cv2.connectedComponents(mask.astype(np.uint8))
    counts = np.bincount(parts[place & mask], minlength=1)
    return parts == counts.argmax() if counts.any() else None


def distance_to(where: np.ndarray) -> np.ndarray:
    """(h, w) float32: pixels to the nearest place that is true; far where there is none."""
    distance = cv2.distanceTransform((~where).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    return np.minimum(distance, np.float32(sum(where.shape)))


def disc(radius_px: float) -> np.ndarray:
    """A window for OpenCV's morphology, (2 r + 1, 2 r + 1) uint8, r being the radius rounded, at least 1."""
    side_px = 2 * max(round(radius_px), 1) + 1
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side_px, side_px))
