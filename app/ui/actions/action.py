"""What an action is: something the user can do, under a name, a key and one plain sentence.

Every action stands once, in the table of app/ui/actions/action_table.py. The keys, the overlay that `?` opens and the
command palette all read that table; the palette lists beside it what has no key (light_actions.py,
setting_actions.py, export_actions.py, answer_actions.py). To add actions:

1. In a module of your own, make a tuple of `Action`. `run` gets the `EditorState` and changes only it; what
   needs the window or a file sets a wish in the state, which the window carries out after the frame.
2. Add the tuple to ACTIONS in app/ui/actions/action_table.py.

A test sees to it that no two actions share a key or a name. Nothing here calls Dear ImGui.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from app.ui.state import EditorState

MODIFIERS = ("Ctrl", "Shift", "Alt")
_SHOWN_KEYS = {"=": "+", "-": "\N{MINUS SIGN}", ",": "Comma", ".": "Period"}
_SHOWN_KEYS |= {"Escape": "Esc", "PageUp": "Page Up", "PageDown": "Page Down"}


def has_photo(state: EditorState) -> bool:
    """Whether a photo is open: when most of what looks at one is available."""
    return state.snapshot.opened is not None


def has_picture(state: EditorState) -> bool:
    """Whether there is a relit picture: when most of what changes or saves one is available."""
    return state.snapshot.picture is not None


@dataclass(frozen=True)
class Chord:
    """A key and the modifiers held with it, all of them and no other.

    Attributes:
        key: a capital letter, a digit, one of - = ? , . or the name of a key: Left, Space, Escape, Tab, F1 ...
    """

    key: str
    ctrl: bool = False
    shift: bool = False
    alt: bool = False

    @property
    def label(self) -> str:
        """As a person reads it: "Ctrl + P", "Esc"."""
        held = [name for name in MODIFIERS if getattr(self, name.lower())]
        return " + ".join([*held, _SHOWN_KEYS.get(self.key, self.key)])


@dataclass(frozen=True)
class Action:
    """One thing the user can do.

    Attributes:
        name: a few words, unique, starting with what is done: "Fit the picture".
        group: the heading it stands under in the overlay.
        keys: chords as text, "Ctrl+Shift+Z"; the first is the one shown. Every action of the table has at least one.
        help: one plain sentence without a full stop.
        run: does it. Of a held action, called when the key goes down.
        let_go: of a held action, called when the key comes up; the palette does not list such an action.
        available: whether it can be done now; else its key does nothing and the palette shows it greyed.
        repeats: it is done again and again while the key is held.
        is_on: of a switch, whether it is on now; the palette shows a tick.
    """

    name: str
    group: str
    keys: tuple[str, ...]
    help: str
    run: Callable[[EditorState], None]
    let_go: Callable[[EditorState], None] | None = None
    available: Callable[[EditorState], bool] = lambda state: True
    repeats: bool = False
    is_on: Callable[[EditorState], bool] | None = None

    @property
    def chords(self) -> tuple[Chord, ...]:
        """The keys, parsed."""
        return tuple(parse_chord(text) for text in self.keys)

    @property
    def label(self) -> str:
        """The first key, as a person reads it; empty where there is none."""
        return self.chords[0].label if self.keys else ""


@dataclass(frozen=True)
class Gesture:
    """Something the mouse does, for the overlay only.

    Attributes:
        hand: what the hand does: "Ctrl + wheel".
        group, help: as of an Action.
    """

    hand: str
    group: str
    help: str


@lru_cache(maxsize=256)
def parse_chord(text: str) -> Chord:
    """ "Ctrl+Shift+Z" as a Chord.

    Raises:
        ValueError: an unknown modifier, or no key.
    """
    *held, key = text.split("+")
    if not key or any(name not in MODIFIERS for name in held):
        raise ValueError(f"no chord: {text!r}")
    return Chord(key, *(name in held for name in MODIFIERS))


def sentence(words: str) -> str:
    """A tooltip as the palette tells it: in one line, without the full stop."""
    return " ".join(words.split()).rstrip(".")


def matching(actions: Sequence[Action], typed: str) -> list[Action]:
    """The actions the palette lists for what was typed, best first; all of them for nothing typed.

    Every typed word must occur in the name, or begin a word of the group or the help. Names that start with what was
    typed come first, then those in which every typed word begins a word, then what only the help tells of or what
    stands inside a word. Case does not matter.
    """
    words = typed.lower().split()
    ranked = []
    for order, action in enumerate(actions):
        if action.let_go is not None:
            continue
        name = action.name.lower()
        hints = f"{action.group} {action.help}".lower().split()
        if all(word in name or any(hint.startswith(word) for hint in hints) for word in words):
            begins = all(any(part.startswith(word) for part in name.split()) for word in words)
            rank = 0 if name.startswith(" ".join(words)) else 1 if begins else 2
            ranked.append((rank, order, action))
    return [action for _, _, action in sorted(ranked, key=lambda entry: entry[:2])]
