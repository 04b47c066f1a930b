"""Who may import whom: dependencies point downward, and each library is known in one place."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MAKERS = ("relight_core.dataset", "relight_core.training", "relight_core.evaluation")
PHOTOS = tuple(f"relight_core.imaging.{module}" for module in ("photo", "read", "write", "formats"))
SCREEN = ("glfw", "moderngl", "imgui_bundle")
RULES = [
    ("relight_core", ("app", *SCREEN)),
    (
        "relight_core/imaging",
        ("relight_core.face", "relight_core.lighting", "relight_core.networks", "relight_core.pipeline", *MAKERS),
    ),
    ("relight_core/lighting", ("relight_core.face", "relight_core.networks", "relight_core.pipeline", *MAKERS)),
    ("relight_core/face", ("relight_core.networks", "relight_core.pipeline", *MAKERS)),
    (
        "relight_core/networks",
        ("relight_core.face", "relight_core.pipeline", "cv2", "PIL", "OpenEXR", *PHOTOS, *MAKERS),
    ),
    ("relight_core/pipeline", MAKERS),
    ("relight_core/dataset", ("relight_core.networks", "relight_core.training", "relight_core.evaluation")),
    ("relight_core/training", ("relight_core.evaluation",)),
    ("app/document", ("app.ui", "app.window", "torch", *SCREEN, *MAKERS)),
    ("app/engine", ("app.document", "app.ui", "app.window", *SCREEN, *MAKERS)),
    ("app/ui", ("app.window", "moderngl", "torch", *MAKERS)),
    ("app/window", ("torch", *MAKERS)),
]


def imported(path):
    """Names of all modules that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute here"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize(("folder", "forbidden"), RULES, ids=[folder for folder, _ in RULES])
def test_dependencies_point_downward(folder, forbidden):
    paths = list((ROOT / folder).rglob("*.py"))
    assert paths
    wrong = {
        f"{path.relative_to(ROOT)} imports {name}"
        for path in paths
        for name in imported(path)
        if any(name == module or name.startswith(f"{module}.") for module in forbidden)
    }
    assert not wrong


def test_the_interface_s_binding_is_known_where_the_interface_is():
    users = {path for path in (ROOT / "app").rglob("*.py") if any("imgui" in name for name in imported(path))}
    assert users - {*(ROOT / "app" / "ui").rglob("*.py")} == {ROOT / "app" / "window" / "gl_interface.py"}
