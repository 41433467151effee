"""Errors that are the user's to mend, and the words that help mending them."""

import difflib
import errno
import os
from collections.abc import Iterable


class UserError(Exception):
    """Input or usage the user can mend (exit 2). The message names the file, line or key, and the mend."""


class InterruptionError(Exception):
    """The user or the system asked the program to stop (exit 130)."""


def nearest_hint(name: str, known: Iterable[str]) -> str:
    """' (did you mean 'x'?)', or nothing when no known name resembles it. The last component of a
    dotted name matches first where it is the same, and last where it only resembles."""
    names = list(known)
    last_component = name.rsplit(".", 1)[-1]
    matches = [candidate for candidate in names if candidate.rsplit(".", 1)[-1] == last_component][:1]
    matches = matches or difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    if not matches:
        by_last_component = {candidate.rsplit(".", 1)[-1]: candidate for candidate in reversed(names)}
        matches = [by_last_component[match] for match in difflib.get_close_matches(last_component, by_last_component, n=1, cutoff=0.6)]
    return f" (did you mean '{matches[0]}'?)" if matches else ""


_MENDS = {
    errno.ENOSPC: "free some space on that disk or choose another --out",
    errno.EDQUOT: "the disk quota is used up: free some space or choose another --out",
    errno.EFBIG: "the file size limit of this system or session is reached: raise it or choose another --out",
    errno.EROFS: "choose another --out",
    errno.EACCES: "check its permissions or choose another path",
    errno.EPERM: "check its permissions or choose another path",
    errno.ENOENT: "check the path",
    errno.EISDIR: "name a file, not a directory",
    errno.ENOTDIR: "a part of the path is a file: choose another path",
    errno.EIO: "the disk reports a fault: choose another disk",
    errno.EMFILE: "raise the limit of open files",
}


def describe_os_error(error: OSError, path: str | None = None) -> str:
    """'missions/a/odometry.csv: Permission denied; check its permissions ...'. `path` replaces the one the error carries."""
    name = path if path is not None else error.filename
    reason = os.strerror(error.errno) if error.errno is not None else str(error)
    mend = _MENDS.get(error.errno or 0, "check the path and the disk")
    return f"{os.fsdecode(name)}: {reason}; {mend}" if name is not None else f"{reason}; {mend}"
