"""Paints what Dear ImGui has listed for a frame."""

from __future__ import annotations

import ctypes

import moderngl
import numpy as np
from imgui_bundle import imgui

from app.window.damage import Piece, Rect, Sheet, cut, damage, seen_in
from app.window.gl_textures import ledger_of
from app.window.shader_source import shader_program

_LAYOUT = "2f 2f 4f1"
_ROOM = 1 << 16


class InterfacePainter:
    """Draws the lists of a frame, all vertices of it in one buffer, which takes far fewer calls than a list at a time.

    Args:
        context: the window's; current whenever a method is called.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = shader_program(context, "interface")
        self._vertices = self._indices = self._array = None
        self._reserve(_ROOM, _ROOM)
        self._ledger = ledger_of(context)
        self._shown: tuple | None = None
        self._own: dict[int, moderngl.Texture] = {}
        self._others: dict[int, moderngl.Texture] = {}
        imgui.get_io().backend_flags |= imgui.BackendFlags_.renderer_has_textures
        largest = context.info["GL_MAX_TEXTURE_SIZE"]
        platform = imgui.get_platform_io()
        platform.renderer_texture_max_width = platform.renderer_texture_max_height = largest

    def paint(self, data: imgui.ImDrawData, target: moderngl.Framebuffer) -> None:
        """Draw a frame over what is in the target, which is as large as the window's framebuffer."""
        self._follow_textures()
        sheets, size, _ = _read(data)
        self._draw(sheets, self._upload(sheets), target, (0, 0, *size))

    def repaint(
        self, data: imgui.ImDrawData, target: moderngl.Framebuffer, background: tuple[float, ...], kept: bool
    ) -> bool:
        """Draw a frame, or only where it differs from the one repainted before; False where it does nowhere.

        Args:
            background: the colour behind all.
            kept: the target still holds that frame. Where it does not, all is drawn if anything is.
        """
        self._follow_textures()
        sheets, size, scale = _read(data)
        self._let_go_of_unseen(sheets)
        touched, self._ledger.touched = self._ledger.touched, {}
        rects = [(0, 0, *size)]
        if self._shown is not None and self._shown[1:] == (size, scale):
            changed = damage(self._shown[0], sheets, touched, size)
            rects = changed if kept or not changed else rects
        self._shown = (sheets, size, scale)
        starts = self._upload(sheets) if rects else []
        for rect in rects:
            # The window's own framebuffer is not told when the window's size changes.
            target.viewport = (0, 0, *size)
            self._draw(sheets, starts, target, rect, background)
        return bool(rects)

    def forget(self) -> None:
        """Draw all at the next repainting: what the target holds may have been lost."""
        self._shown = None

    def _draw(
        self,
        sheets: tuple[Sheet, ...],
        starts: list[int],
        target: moderngl.Framebuffer,
        rect: Rect,
        background: tuple[float, ...] | None = None,
    ) -> None:
        """What lies in a rectangle of the target, which is as large as its viewport; None clears nothing first."""
        width, height = target.viewport[2:]
        pieces, hides = seen_in(rect, sheets, self._ledger.opaque)
        if background is not None and not hides:
            target.clear(*background, viewport=(rect[0], height - rect[3], rect[2] - rect[0], rect[3] - rect[1]))
        target.use()
        self._program["window_size"].value = (width, height)
        self._context.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._context.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        for index, piece, (x0, y0, x1, y1) in pieces:
            self._prepare(piece)
            target.scissor = x0, height - y1, x1 - x0, y1 - y0
            self._array.render(moderngl.TRIANGLES, piece.count, first=starts[index] + piece.first)
        target.scissor = None

    def _prepare(self, piece: Piece) -> None:
        """Texture and blending of a piece; in software, mixing with what is there costs time."""
        self._texture(piece.texture).use(0)
        if piece.texture in self._ledger.opaque:
            self._context.disable(moderngl.BLEND)
        else:
            self._context.enable(moderngl.BLEND)

    def close(self) -> None:
        """Free everything; before the Dear ImGui context goes."""
        for data in imgui.get_platform_io().textures:
            data.set_tex_id(0)
            data.status = imgui.ImTextureStatus.destroyed
        for item in (*self._own.values(), self._array, self._vertices, self._indices, self._program):
            item.release()
        imgui.get_io().backend_flags &= ~imgui.BackendFlags_.renderer_has_textures

    def _upload(self, sheets: tuple[Sheet, ...]) -> list[int]:
        """All vertices and indices of a frame; where each sheet's indices begin."""
        indices, starts, first_vertex, first_index = [], [], 0, 0
        for sheet in sheets:
            indices.append(sheet.indices.astype(np.uint32) + np.uint32(first_vertex))
            starts.append(first_index)
            first_vertex += len(sheet.vertices)
            first_index += len(sheet.indices)
        self._reserve(first_vertex * imgui.VERTEX_SIZE, 4 * first_index)
        # A new store each frame, so that nobody waits for the last one to be drawn.
        for buffer in (self._vertices, self._indices):
            buffer.orphan()
        if first_index:
            self._vertices.write(np.concatenate([sheet.vertices for sheet in sheets]))
            self._indices.write(np.concatenate(indices))
        return starts

    def _reserve(self, vertex_bytes: int, index_bytes: int) -> None:
        have = (self._vertices.size, self._indices.size) if self._array else (0, 0)
        if vertex_bytes <= have[0] and index_bytes <= have[1]:
            return
        for item in (self._array, self._vertices, self._indices):
            if item is not None:
                item.release()
        self._vertices = self._context.buffer(reserve=max(2 * vertex_bytes, have[0]), dynamic=True)
        self._indices = self._context.buffer(reserve=max(2 * index_bytes, have[1]), dynamic=True)
        content = [(self._vertices, _LAYOUT, "position", "texel", "colour")]
        self._array = self._context.vertex_array(self._program, content, self._indices, index_element_size=4)

    def _texture(self, number: int) -> moderngl.Texture:
        texture = self._own.get(number) or self._others.get(number)
        if texture is None:
            texture = self._others[number] = self._context.external_texture(number, (1, 1), 4, 0, "f1")
        return texture

    def _let_go_of_unseen(self, sheets: tuple[Sheet, ...]) -> None:
        """Keep no wrapper of a texture the frame does not show: each new size of the viewport has a new number."""
        seen = {piece.texture for sheet in sheets for piece in sheet.pieces}
        for number in self._others.keys() - seen:
            # Of a texture that is not its own, this frees the wrapper alone.
            self._others.pop(number).release()

    def _follow_textures(self) -> None:
        """Make, mend and free the textures of Dear ImGui itself: its letters."""
        status = imgui.ImTextureStatus
        for data in imgui.get_platform_io().textures:
            if data.status == status.want_create:
                texture = self._context.texture((data.width, data.height), 4, data.get_pixels_array().tobytes())
                texture.repeat_x = texture.repeat_y = False
                self._own[texture.glo] = texture
                self._ledger.touch(texture)
                data.set_tex_id(texture.glo)
                data.status = status.ok
            elif data.status == status.want_updates:
                self._mend(data)
                data.status = status.ok
            elif data.status == status.want_destroy and data.unused_frames > 0:
                self._own.pop(data.tex_id).release()
                data.set_tex_id(0)
                data.status = status.destroyed

    def _mend(self, data: imgui.ImTextureData) -> None:
        pixels = data.get_pixels_array().reshape(data.height, data.width, 4)
        texture = self._own[data.tex_id]
        for part in data.updates:
            block = np.ascontiguousarray(pixels[part.y : part.y + part.h, part.x : part.x + part.w])
            texture.write(block, viewport=(part.x, part.y, part.w, part.h))


def _read(data: imgui.ImDrawData) -> tuple[tuple[Sheet, ...], tuple[int, int], tuple[float, float]]:
    """A frame as sheets in framebuffer pixels, the framebuffer's size, and the scale it was listed at."""
    across, down = data.framebuffer_scale.x, data.framebuffer_scale.y
    size = round(data.display_size.x * across), round(data.display_size.y * down)
    return tuple(_sheet(commands, across, down, size) for commands in data.cmd_lists), size, (across, down)


def _sheet(commands: imgui.ImDrawList, across: float, down: float, size: tuple[int, int]) -> Sheet:
    vertices = np.frombuffer(_bytes_of(commands.vtx_buffer, imgui.VERTEX_SIZE), np.uint32).reshape(-1, 5).copy()
    if (across, down) != (1.0, 1.0):
        vertices[:, :2].view(np.float32)[...] *= np.float32((across, down))
    indices = np.frombuffer(_bytes_of(commands.idx_buffer, imgui.INDEX_SIZE), f"u{imgui.INDEX_SIZE}").copy()
    pieces = []
    for command in commands.cmd_buffer:
        x0, y0, x1, y1 = command.clip_rect
        clip = cut((int(x0 * across), int(y0 * down), int(x1 * across), int(y1 * down)), (0, 0, *size))
        if clip and command.elem_count:
            pieces.append(Piece(clip, command.tex_ref.get_tex_id(), command.idx_offset, command.elem_count))
    return Sheet(commands._owner_name, vertices, indices, tuple(pieces))


def _bytes_of(buffer: object, item_size: int) -> memoryview | bytes:
    count = buffer.size() * item_size
    return memoryview((ctypes.c_char * count).from_address(buffer.data_address())) if count else b""
