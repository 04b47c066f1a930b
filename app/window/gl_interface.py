"""Draws Dear ImGui's draw lists with OpenGL."""

from __future__ import annotations

import ctypes

import moderngl
import numpy as np
from imgui_bundle import imgui

from app.window.damage import DrawCommand, DrawList, Rect, cut, damage, seen_in
from app.window.gl_textures import ledger_of
from app.window.shader_source import shader_program

_LAYOUT = "2f 2f 4f1"
_ROOM = 1 << 16


class InterfacePainter:
    """Draws the draw lists of a frame from a single vertex buffer, with far fewer calls than a buffer for each list.

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
        draw_lists, size, _ = _read(data)
        self._draw(draw_lists, self._upload(draw_lists), target, (0, 0, *size))

    def repaint(
        self, data: imgui.ImDrawData, target: moderngl.Framebuffer, background: tuple[float, ...], kept: bool
    ) -> bool:
        """Draw a frame where it differs from the one repainted before; False if it does not differ.

        Args:
            background: the colour behind all.
            kept: the target still holds the frame before. If it does not, everything is drawn if anything differs.
        """
        self._follow_textures()
        draw_lists, size, scale = _read(data)
        self._let_go_of_unseen(draw_lists)
        touched, self._ledger.touched = self._ledger.touched, {}
        rects = [(0, 0, *size)]
        if self._shown is not None and self._shown[1:] == (size, scale):
            changed = damage(self._shown[0], draw_lists, touched, size)
            rects = changed if kept or not changed else rects
        self._shown = (draw_lists, size, scale)
        starts = self._upload(draw_lists) if rects else []
        for rect in rects:
            # The window's own framebuffer is not told when the window's size changes.
            target.viewport = (0, 0, *size)
            self._draw(draw_lists, starts, target, rect, background)
        return bool(rects)

    def forget(self) -> None:
        """Redraw everything next time: the target's contents may have been lost."""
        self._shown = None

    def _draw(
        self,
        draw_lists: tuple[DrawList, ...],
        starts: list[int],
        target: moderngl.Framebuffer,
        rect: Rect,
        background: tuple[float, ...] | None = None,
    ) -> None:
        """Draw a rectangle of the target, whose size is its viewport's; a background clears it first."""
        width, height = target.viewport[2:]
        commands, hides = seen_in(rect, draw_lists, self._ledger.opaque)
        if background is not None and not hides:
            target.clear(*background, viewport=(rect[0], height - rect[3], rect[2] - rect[0], rect[3] - rect[1]))
        target.use()
        self._program["window_size"].value = (width, height)
        self._context.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._context.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        for index, command, (x0, y0, x1, y1) in commands:
            self._prepare(command)
            target.scissor = x0, height - y1, x1 - x0, y1 - y0
            self._array.render(moderngl.TRIANGLES, command.count, first=starts[index] + command.first)
        target.scissor = None

    def _prepare(self, command: DrawCommand) -> None:
        """Set the texture and blending of a command; opaque textures are not blended, which saves time in software."""
        self._texture(command.texture).use(0)
        if command.texture in self._ledger.opaque:
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

    def _upload(self, draw_lists: tuple[DrawList, ...]) -> list[int]:
        """Upload all vertices and indices of a frame.

        Returns:
            where each draw list's indices begin.
        """
        indices, starts, first_vertex, first_index = [], [], 0, 0
        for draw_list in draw_lists:
            indices.append(draw_list.indices.astype(np.uint32) + np.uint32(first_vertex))
            starts.append(first_index)
            first_vertex += len(draw_list.vertices)
            first_index += len(draw_list.indices)
        self._reserve(first_vertex * imgui.VERTEX_SIZE, 4 * first_index)
        # New storage for each frame, so that the upload need not wait until the last frame is drawn.
        for buffer in (self._vertices, self._indices):
            buffer.orphan()
        if first_index:
            self._vertices.write(np.concatenate([draw_list.vertices for draw_list in draw_lists]))
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

    def _let_go_of_unseen(self, draw_lists: tuple[DrawList, ...]) -> None:
        """Drop the wrappers of textures that the frame does not show: a viewport of another size has a new texture."""
        seen = {command.texture for draw_list in draw_lists for command in draw_list.commands}
        for number in self._others.keys() - seen:
            # Of a texture that is not its own, this frees the wrapper alone.
            self._others.pop(number).release()

    def _follow_textures(self) -> None:
        """Create, update and free Dear ImGui's own textures, its font atlas."""
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


def _read(data: imgui.ImDrawData) -> tuple[tuple[DrawList, ...], tuple[int, int], tuple[float, float]]:
    """A frame's draw lists in framebuffer pixels, the framebuffer's size, and the scale it was listed at."""
    across, down = data.framebuffer_scale.x, data.framebuffer_scale.y
    size = round(data.display_size.x * across), round(data.display_size.y * down)
    return tuple(_draw_list(listed, across, down, size) for listed in data.cmd_lists), size, (across, down)


def _draw_list(listed: imgui.ImDrawList, across: float, down: float, size: tuple[int, int]) -> DrawList:
    vertices = np.frombuffer(_bytes_of(listed.vtx_buffer, imgui.VERTEX_SIZE), np.uint32).reshape(-1, 5).copy()
    if (across, down) != (1.0, 1.0):
        vertices[:, :2].view(np.float32)[...] *= np.float32((across, down))
    indices = np.frombuffer(_bytes_of(listed.idx_buffer, imgui.INDEX_SIZE), f"u{imgui.INDEX_SIZE}").copy()
    commands = []
    for command in listed.cmd_buffer:
        x0, y0, x1, y1 = command.clip_rect
        clip = cut((int(x0 * across), int(y0 * down), int(x1 * across), int(y1 * down)), (0, 0, *size))
        if clip and command.elem_count:
            commands.append(DrawCommand(clip, command.tex_ref.get_tex_id(), command.idx_offset, command.elem_count))
    return DrawList(listed._owner_name, vertices, indices, tuple(commands))


def _bytes_of(buffer: object, item_size: int) -> memoryview | bytes:
    count = buffer.size() * item_size
    return memoryview((ctypes.c_char * count).from_address(buffer.data_address())) if count else b""
