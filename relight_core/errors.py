"""The one exception that means "the input is at fault, and here is the mend"."""


class InputError(ValueError):
    """Input the user can mend: a file that is no image, a light of the wrong shape, a path that can't be written.

    The message is one line that names the file or setting and says what to do. The command line
    prints it to stderr and exits with 2; the window shows it and keeps its previous state.
    """


class NoFaceError(InputError):
    """A photo in which no face is found. Whoever can be asked where it is need not give up."""
