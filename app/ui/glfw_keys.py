"""Which of Dear ImGui's keys a glfw key is."""

from __future__ import annotations

import glfw
from imgui_bundle import imgui

_SAME_NAMES = (
    *("TAB", "BACKSPACE", "ENTER", "ESCAPE", "INSERT", "DELETE", "SPACE", "PAGE_UP", "PAGE_DOWN", "HOME", "END"),
    *("APOSTROPHE", "COMMA", "MINUS", "PERIOD", "SLASH", "SEMICOLON", "EQUAL", "LEFT_BRACKET", "BACKSLASH"),
    *("RIGHT_BRACKET", "GRAVE_ACCENT", "CAPS_LOCK", "SCROLL_LOCK", "NUM_LOCK", "PRINT_SCREEN", "PAUSE", "MENU"),
    *(f"F{number}" for number in range(1, 13)),
    *(chr(code) for code in range(ord("A"), ord("Z") + 1)),
)
_RENAMED = (
    *((side, f"{side.lower()}_arrow") for side in ("LEFT", "RIGHT", "UP", "DOWN")),
    *(
        (f"{side}_{glfw_name}", f"{side.lower()}_{name}")
        for side in ("LEFT", "RIGHT")
        for glfw_name, name in (("CONTROL", "ctrl"), ("SHIFT", "shift"), ("ALT", "alt"), ("SUPER", "super"))
    ),
    *((str(digit), f"_{digit}") for digit in range(10)),
    *((f"KP_{digit}", f"keypad{digit}") for digit in range(10)),
    *(
        (f"KP_{name}", f"keypad_{name.lower()}")
        for name in ("ENTER", "DECIMAL", "DIVIDE", "MULTIPLY", "SUBTRACT", "ADD", "EQUAL")
    ),
)

KEYS: dict[int, imgui.Key] = {
    getattr(glfw, f"KEY_{glfw_name}"): getattr(imgui.Key, name)
    for glfw_name, name in (*((name, name.lower()) for name in _SAME_NAMES), *_RENAMED)
}
"""From a glfw key's number to the key."""
