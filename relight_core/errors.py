"""The one exception that means "the input is at fault, and here is the mend"."""

import re

_CONTROLS = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029]")


def without_controls(line: str) -> str:
    """A line with a replacement character for what would break or overwrite it, which files' names may hold."""
    return _CONTROLS.sub("\N{REPLACEMENT CHARACTER}", line)


class InputError(ValueError):
    """Input the user can mend: a file that is no image, a light of the wrong shape, a path that can't be written.

    The message is one line that names the file or setting and says what to do; of work on many files it is several,
    each an argument. The command line prints it to stderr and exits with 2; the window shows it and keeps its previous
    state.
    """

    def __str__(self) -> str:
        return "\n".join(without_controls(str(line)) for line in self.args)


class NoFaceError(InputError):
    """A photo in which no face is found. Whoever can be asked where it is need not give up."""
