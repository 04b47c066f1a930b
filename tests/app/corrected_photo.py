"""A photo in which faces and the outline were corrected by hand, and the same corrections at half its size."""

from app.document.document import PhotoRef
from relight_core.face.find import FaceBox
from relight_core.pipeline.per_photo.brush import BrushStroke

BOXES = (FaceBox(10.0, 12.0, 30.0, 36.0, 12.5), FaceBox(-4.0, 2.0, 16.0, 22.0))
HALF = (FaceBox(5.0, 6.0, 15.0, 18.0, 12.5), FaceBox(-2.0, 1.0, 8.0, 11.0))
STROKES = (BrushStroke(((8.2, -3.0), (40.0, 20.4)), 6.0, True),)
HALF_STROKES = (BrushStroke(((4.1, -1.5), (20.0, 10.2)), 3.0, True),)
LARGE, SMALL, CROPPED = (80, 60), (40, 30), (60, 60)


def corrected(path, size=LARGE, face_index=1):
    return PhotoRef(path, face_index, BOXES, strokes=STROKES, size=size)


def held(portrait):
    return portrait.face_index, portrait.boxes, portrait.strokes, portrait.size
