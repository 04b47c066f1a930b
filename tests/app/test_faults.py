"""What is told of an error: the same words in the window, in a batch and on the command line."""

from live_editor import Editor

from app.faults import error_line
from relight_core.errors import InputError


def test_an_input_error_speaks_for_itself_and_any_other_is_owned_up_to_in_one_line():
    assert error_line(InputError("a.jpg: no such file")) == "a.jpg: no such file"
    assert error_line(ValueError("two\nlines")) == "A fault of ours, not of your input (ValueError: two lines)"


def test_what_the_window_says_of_no_file_begins_with_a_capital():
    editor = Editor(None)
    editor.state.asking.wish("save_session")
    editor.live(1)
    editor.deeds.close()
    assert editor.said == [("There is no photo to save a session of; open one first", True)]
