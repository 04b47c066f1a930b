"""Paints what Dear ImGui has listed for a frame."""

from __future__ import annotations

import ctypes

import moderngl
import numpy as np
from imgui_bundle import imgui

from app.window.shader_source import stage_source

_LAYOUT = "2f 2f 4f1"
_ROOM = 1 << 16


class InterfacePainter:
    """Draws the lists of a frame, all vertices of it in one buffer, which takes far fewer calls than a list at a time.

    Args:
        context: the window's; current whenever a method is called.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        stages = (stage_source("interface", stage) for stage in ("VERTEX_STAGE", "FRAGMENT_STAGE"))
        self._program = context.program(*stages)
        self._vertices = self._indices = self._array = None
        self._reserve(_ROOM, _ROOM)
        self._own: dict[int, moderngl.Texture] = {}
        self._others: dict[int, moderngl.Texture] = {}
        imgui.get_io().backend_flags |= imgui.BackendFlags_.renderer_has_textures
        largest = context.info["GL_MAX_TEXTURE_SIZE"]
        platform = imgui.get_platform_io()
        platform.renderer_texture_max_width = platform.renderer_texture_max_height = largest

    def paint(self, data: imgui.ImDrawData, target: moderngl.Framebuffer) -> None:
        """Draw a frame over what is in the target, which is as large as the window's framebuffer."""
        self._follow_textures()
        size, scale = data.display_size, data.framebuffer_scale
        if size.x <= 0 or size.y <= 0:
            return
        target.use()
        height = round(size.y * scale.y)
        self._program["window_size"].value = (size.x, size.y)
        self._context.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._context.enable(moderngl.BLEND)
        self._context.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        lists = data.cmd_lists
        for commands, first in zip(lists, self._upload(lists), strict=True):
            for command in commands.cmd_buffer:
                x0, y0, x1, y1 = command.clip_rect
                left, low = max(int(x0 * scale.x), 0), max(int(height - y1 * scale.y), 0)
                wide, high = int(x1 * scale.x) - left, int(height - y0 * scale.y) - low
                if wide > 0 and high > 0 and command.elem_count:
                    target.scissor = left, low, wide, high
                    self._texture(command.tex_ref.get_tex_id()).use(0)
                    self._array.render(moderngl.TRIANGLES, command.elem_count, first=first + command.idx_offset)
        target.scissor = None

    def close(self) -> None:
        """Free everything; before the Dear ImGui context goes."""
        for data in imgui.get_platform_io().textures:
            data.set_tex_id(0)
            data.status = imgui.ImTextureStatus.destroyed
        for item in (*self._own.values(), self._array, self._vertices, self._indices, self._program):
            item.release()
        imgui.get_io().backend_flags &= ~imgui.BackendFlags_.renderer_has_textures

    def _upload(self, lists: list) -> list[int]:
        """All vertices and indices of a frame; where each list's indices begin."""
        vertices = [_bytes_of(commands.vtx_buffer, imgui.VERTEX_SIZE) for commands in lists]
        indices, starts, first_vertex, first_index = [], [], 0, 0
        for commands, data in zip(lists, vertices, strict=True):
            numbers = np.frombuffer(_bytes_of(commands.idx_buffer, imgui.INDEX_SIZE), f"u{imgui.INDEX_SIZE}")
            indices.append(numbers.astype(np.uint32) + np.uint32(first_vertex))
            starts.append(first_index)
            first_vertex += len(data) // imgui.VERTEX_SIZE
            first_index += len(numbers)
        self._reserve(first_vertex * imgui.VERTEX_SIZE, 4 * first_index)
        # A new store each frame, so that nobody waits for the last one to be drawn.
        for buffer in (self._vertices, self._indices):
            buffer.orphan()
        if first_index:
            self._vertices.write(b"".join(vertices))
            self._indices.write(np.concatenate(indices).tobytes())
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

    def _follow_textures(self) -> None:
        """Make, mend and free the textures of Dear ImGui itself: its letters."""
        status = imgui.ImTextureStatus
        for data in imgui.get_platform_io().textures:
            if data.status == status.want_create:
                texture = self._context.texture((data.width, data.height), 4, data.get_pixels_array().tobytes())
                texture.repeat_x = texture.repeat_y = False
                self._own[texture.glo] = texture
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


def _bytes_of(buffer: object, item_size: int) -> memoryview | bytes:
    count = buffer.size() * item_size
    return memoryview((ctypes.c_char * count).from_address(buffer.data_address())) if count else b""
