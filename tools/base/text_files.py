"""Files of a user, read whole. Errors: BadInput with the name of what cannot be read."""
from pathlib import Path

from tools.base.command import BadInput


def bytes_of(path, called):
    """The bytes of a file. called: what messages name it. Raises BadInput."""
    try:
        return Path(path).read_bytes()
    except OSError as problem:
        raise BadInput(f"cannot read {called}: {problem.strerror or problem}") from None


def text_of(path, called, errors="strict"):
    """The text of a file, line ends as they are. errors: "replace" takes any letters. Raises BadInput."""
    data = bytes_of(path, called)
    try:
        if b"\0" not in data:
            return data.decode("utf-8-sig", errors)
    except UnicodeDecodeError:
        pass
    raise BadInput(f"{called} is no plain text (UTF-16, Latin-1 or binary); save it as UTF-8 text")
