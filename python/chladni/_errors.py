"""The exceptions, one family: ``except chladni.Error`` catches all of them."""

from errno import ENOENT


class Error(Exception):
    """What this package raises; its message says what, where and why."""


class InputError(Error, ValueError):
    """What was given is nothing to compute with: NaN, a wrong shape or type, a matrix that is not symmetric."""


class NotCertifiedError(Error, RuntimeError):
    """The pairs that were found did not pass their check, so that none are returned."""


class RanksError(Error, RuntimeError):
    """The ranks of SLEPc ended without a result: the message says why."""


class FileError(Error, OSError):
    """A mesh could not be read or written."""


class MissingFileError(FileError, FileNotFoundError):
    """There is no such file; ``errno`` is ENOENT."""

    # Of the class, since pickles hold the message alone.
    errno = ENOENT


class InternalError(Error, RuntimeError):
    """A bug of the engines."""


class ChladniWarning(UserWarning):
    """A result that is not quite as it was asked for, such as a match that is in doubt."""
