"""Looking for the faces of one photo: what de-lighting's parsing makes of its views, each of which is read once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from relight_core.errors import NoFaceError
from relight_core.face.crop import Crop
from relight_core.face.evidence import certainty_of_face, evidence_of_face, glimpses_of_face
from relight_core.face.find import FaceBox
from relight_core.imaging.colour import luminance
from relight_core.imaging.photo import Photo
from relight_core.pipeline.face_taken_apart import Workshop
from relight_core.pipeline.per_photo.choosing_faces import choose_faces
from relight_core.pipeline.per_photo.exposing import exposure_of_view, sampled_pixels
from relight_core.pipeline.per_photo.network_view import network_view
from relight_core.pipeline.per_photo.portrait import frame, framed, located
from relight_core.pipeline.quality import tier_of
from relight_core.unwanted import stop_if_unwanted

_LEAST_CERTAIN = 0.54
"""Of the parsing, where a face is found beside others: tiny faces have 0.57, others 0.66 and more; a heap of jeans in
which it saw brows, eyes and a mouth had 0.51."""

_LEAST_CONTRAST = 0.1
"""By this share of its brightest parts the darkest of a face are darker, at the least: in white paper, which has 0.05,
the parsing sees a face. Those of photos overexposed by two stops, or of so few codes that they are black, have 0.67."""

_MOST_HIDDEN = 0.5
"""Alpha up to which the finder sees more of the grey behind a pixel than of the pixel."""


class FaceSearch:
    """A photo under the eyes of the parsing (`choosing_faces.Eyes`), at the tier that is quickest."""

    def __init__(self, shop: Workshop, photo: Photo) -> None:
        """Look at nothing yet."""
        self._shop, self._photo = shop, photo
        self._tier = replace(tier_of("live"), looks_twice=False, takes_foreign_shadow_off=False)
        self._known: dict[Crop, np.ndarray] = {}

    def labels(self, view: Crop) -> np.ndarray:
        """(S, S) the likeliest class of each pixel of a view."""
        return self.parsing(view).argmax(0)

    def faces(self) -> list[FaceBox]:
        """The faces that the finder sees and the parsing confirms.

        Raises:
            NoFaceError: there are none.
            UnwantedError: nobody waits for them any more.
        """
        try:
            found = choose_faces(self._photo.seen, self)
        except NoFaceError:
            if (hidden := self._why_hidden()) is None:
                raise
            raise hidden from None
        return [replace(face, doubtful=False) for face in found]

    def _why_hidden(self) -> NoFaceError | None:
        """What is at fault where nobody is found in a photo whose alpha leaves hardly anything to be seen."""
        photo = self._photo
        if photo.alpha is None or photo.alpha.max() > _MOST_HIDDEN:
            return None
        name, percent = photo.path or "the photo", f"{100 * photo.alpha.max():.1f}"
        return NoFaceError(
            f"{name}: no face found, for its alpha is nowhere above {percent} %; export it without alpha, or opaque"
        )

    def parsing(self, view: Crop) -> np.ndarray:
        """(classes, S, S) probabilities of a view's parsing, found once."""
        if view not in self._known:
            self._known[view] = self._parse(view)
        return self._known[view]

    def evidence(self, box: FaceBox) -> int:
        """How many parts of a face are seen there."""
        portrait = frame(self._photo, box)
        return evidence_of_face(self.labels(portrait.view), portrait.view, portrait.crop)

    def glimpse(self, box: FaceBox) -> int:
        """How many parts of a face are only suspected there."""
        portrait = frame(self._photo, box)
        return glimpses_of_face(self.parsing(portrait.view), portrait.view, portrait.crop)

    def locate(self, view: Crop) -> FaceBox | None:
        """The face that the parsing of a view shows, if any."""
        place = located(self._photo, view, self.parsing)
        return place if place is not None and self._has_contrast(place) else None

    def look_closer(self, box: FaceBox) -> int:
        """The evidence where the parsing is certain of a face, as it is framed at last."""
        first = frame(self._photo, box)
        if certainty_of_face(self.parsing(first.view), first.view, first.crop) < _LEAST_CERTAIN:
            return 0
        portrait = framed(self._photo, box, self.parsing)
        if portrait.face == portrait.found:
            return 0
        # The framing may come out wider, and brows then too small to be seen.
        return max(evidence_of_face(self.labels(portrait.view), portrait.view, portrait.crop), self.evidence(box))

    def _parse(self, view: Crop) -> np.ndarray:
        stop_if_unwanted()
        seen = network_view(self._photo, view, self._tier.size, exposure_of_view(self._photo, view))
        found = self._shop.delight(seen, self._tier)
        return found.parsing[0].float().cpu().numpy()

    def _has_contrast(self, place: FaceBox) -> bool:
        middle = Crop((place.x0 + place.x1) / 2, (place.y0 + place.y1) / 2, min(place.width, place.height))
        dark, bright = np.percentile(luminance(sampled_pixels(self._photo, middle)), (2, 98))
        return bool(bright - dark > _LEAST_CONTRAST * bright)
