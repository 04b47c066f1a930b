"""Textures from arrays: uploaded when the array is another one, kept in place when only its contents are."""

from __future__ import annotations

import moderngl
import numpy as np

from app.window.damage import WHOLE, Part

_TYPES = {np.dtype(np.uint8): "f1", np.dtype(np.float16): "f2", np.dtype(np.float32): "f4"}


class Ledger:
    """What the interface's painter has to know of textures that Dear ImGui tells it only the numbers of.

    Attributes:
        touched: those whose contents have changed since the painter last looked, and in which part: x0, y0, x1, y1
            as shares of the texture. The painter empties it.
        opaque: those that nothing shines through.
    """

    def __init__(self) -> None:
        self.touched: dict[int, Part] = {}
        self.opaque: set[int] = set()

    def touch(self, texture: moderngl.Texture, part: Part = WHOLE) -> None:
        """Note that a part of a texture has other contents now."""
        x0, y0, x1, y1 = self.touched.get(texture.glo, part)
        self.touched[texture.glo] = min(x0, part[0]), min(y0, part[1]), max(x1, part[2]), max(y1, part[3])


def ledger_of(context: moderngl.Context) -> Ledger:
    """The one ledger of a context."""
    if context.extra is None:
        context.extra = Ledger()
    return context.extra


class TextureSlot:
    """One texture that follows an array (h, w, channels) of uint8, float16 or float32.

    Attributes:
        array: what the texture holds; None while there is none.
        texture: None while there is no array.
    """

    def __init__(self, context: moderngl.Context, *, mipmaps: bool = False, repeat_x: bool = False) -> None:
        self._context = context
        self._mipmaps = mipmaps
        self._repeat_x = repeat_x
        self.array: np.ndarray | None = None
        self.texture: moderngl.Texture | None = None

    def show(self, array: np.ndarray | None) -> bool:
        """Upload the array unless it is the one already there; None frees the texture. True if it changed."""
        if array is self.array:
            return False
        self.array = array
        if array is None:
            self.close()
            return True
        stored = np.ascontiguousarray(self._stored(array))
        self._fit(stored)
        self.texture.write(stored)
        if self._mipmaps:
            self.texture.build_mipmaps()
        self.smooth(True)
        ledger_of(self._context).touch(self.texture)
        return True

    def smooth(self, magnified_smoothly: bool) -> None:
        """Choose between blended and crisp pixels where the texture is magnified."""
        small = moderngl.LINEAR_MIPMAP_LINEAR if self._mipmaps else moderngl.LINEAR
        self.texture.filter = (small, moderngl.LINEAR if magnified_smoothly else moderngl.NEAREST)

    @property
    def size(self) -> tuple[int, int] | None:
        """Width and height of what it shows; None while there is nothing."""
        return self.texture.size if self.texture else None

    @property
    def glimpse(self) -> np.ndarray | None:
        """What the scopes read while a hand moves something: the array itself, which is there already."""
        return self.array

    @property
    def has_alpha(self) -> bool:
        """Whether what is behind the texture shows through."""
        return self.texture.components == 4

    def switches(self) -> tuple[str, ...]:
        """Which parts of the viewport's shader draw it: none beyond what all have."""
        return ()

    def bind(self, program: moderngl.Program, width_px: float) -> None:
        """Hand the texture to the viewport's program, on unit 0; how wide it is drawn is seen to by the sampler."""
        self.texture.use(0)

    def let_go(self) -> None:
        """Forget the array; the texture's memory stays for the next one of its size, since a driver takes long to get
        it and to make room for mipmaps."""
        self.array = None

    def close(self) -> None:
        """Free the texture; the slot can be used again."""
        self.array = None
        if self.texture is not None:
            self.texture.release()
            self.texture = None

    def _stored(self, array: np.ndarray) -> np.ndarray:
        """What the texture holds of the array."""
        return array

    def _fit(self, array: np.ndarray) -> None:
        height, width, channels = array.shape
        kind = _TYPES[array.dtype]
        texture = self.texture
        if texture is not None and (texture.size, texture.components, texture.dtype) == (
            (width, height),
            channels,
            kind,
        ):
            return
        if texture is not None:
            texture.release()
        self.texture = self._context.texture((width, height), channels, alignment=1, dtype=kind)
        self.texture.repeat_x, self.texture.repeat_y = self._repeat_x, False


class PictureSlot(TextureSlot):
    """A picture for the viewport's shader, with mipmaps.

    What it holds of (h, w, 4) has the alpha multiplied into the colour, so that where the texture is averaged or
    blended what is transparent has no say in the colour beside it.
    """

    def __init__(self, context: moderngl.Context) -> None:
        super().__init__(context, mipmaps=True)

    def _stored(self, array: np.ndarray) -> np.ndarray:
        if array.shape[2] < 4:
            return array
        stored = array.copy()
        stored[..., :3] *= array[..., 3:]
        return stored


class Canvas:
    """A framebuffer of 8-bit RGBA that grows and shrinks with what is asked of it.

    Args:
        smooth: its pixels are blended where it is drawn at another size; one shown pixel by pixel is drawn
            faster without.
        opaque: whatever is drawn on it has alpha 1.
    """

    def __init__(self, context: moderngl.Context, *, smooth: bool = True, opaque: bool = False) -> None:
        self._context = context
        self._opaque = opaque
        self._filter = moderngl.LINEAR if smooth else moderngl.NEAREST
        self.framebuffer: moderngl.Framebuffer | None = None

    @property
    def texture(self) -> moderngl.Texture:
        """What was drawn."""
        return self.framebuffer.color_attachments[0]

    def fit(self, size: tuple[int, int]) -> bool:
        """Make the canvas `size` (width, height) pixels large; True if its contents were lost."""
        if self.framebuffer is not None and self.framebuffer.size == size:
            return False
        self.close()
        texture = self._context.texture(size, 4)
        texture.filter = (self._filter, self._filter)
        texture.repeat_x = texture.repeat_y = False
        self.framebuffer = self._context.framebuffer([texture])
        if self._opaque:
            ledger_of(self._context).opaque.add(texture.glo)
        return True

    def begin(self, part: Part = WHOLE) -> None:
        """Let what is drawn from now on be drawn here; it will differ from what was there in this part at most."""
        self.framebuffer.use()
        ledger_of(self._context).touch(self.texture, part)

    def pixels(self) -> np.ndarray:
        """(h, w, 3) uint8, in the order it was drawn: row 0 is y = 0 of the drawing."""
        width, height = self.framebuffer.size
        data = self.framebuffer.read(components=3, alignment=1)
        return np.frombuffer(data, np.uint8).reshape(height, width, 3).copy()

    def close(self) -> None:
        """Free it."""
        if self.framebuffer is not None:
            # moderngl binds what was in use again when it makes a framebuffer; that must not be a freed one.
            self._context.screen.use()
            ledger_of(self._context).opaque.discard(self.texture.glo)
            self.texture.release()
            self.framebuffer.release()
            self.framebuffer = None
