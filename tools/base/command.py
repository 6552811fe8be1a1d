"""What every command line tool shares: how it reads its options and how it ends.

Exit statuses: 0 done, 1 a comparison failed, 3 bad input with one line on the
error stream that says what, where and what to do, 128 + signal when stopped from outside.
"""
import argparse
import math
import os
import re
import signal
import sys
from contextlib import suppress
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
BAD_INPUT = 3
LEAST, MOST = 1e-30, 1e30  # of a positive argument


class BadInput(Exception):
    """An argument or an input file that cannot be used; the text is one line for the user."""


class Ended(KeyboardInterrupt):
    """The process is to end, by a signal that is not the keyboard's; what stops for that stops for this."""


class Given(argparse._StoreAction):
    """An option that is given once, or whose values (nargs + or *) are those of all the times that it is given."""

    read = None  # the namespace of the last call

    def __call__(self, parser, namespace, values, option_string=None):
        if self.option_strings and self.read is namespace:
            if self.nargs not in ("+", "*"):
                parser.error(f"argument {option_string}: given twice")
            values = [*getattr(namespace, self.dest), *values]
        self.read = namespace
        super().__call__(parser, namespace, values, option_string)


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line and status 3; no option replaces an earlier one of its name."""

    def __init__(self, *args, **options):
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        options.setdefault("allow_abbrev", False)
        super().__init__(*args, **options)
        for name in (None, "store"):
            self.register("action", name, Given)

    def error(self, message):
        self.exit(BAD_INPUT, f"error: {message} ({self.prog} --help lists the options)\n")


def number(text):
    """An argument type: a finite number."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not a finite number")
    return value


def positive(text):
    """An argument type: a number above 0, of which squares and quotients are numbers too."""
    value = number(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} must be positive")
    if not LEAST <= value <= MOST:
        raise argparse.ArgumentTypeError(f"{text} must be between {LEAST:g} and {MOST:g}")
    return value


def non_negative(text):
    """An argument type: a number that is at least 0."""
    value = number(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} must not be negative")
    return value


def whole(least):
    """An argument type: a whole number that is at least `least`."""

    def read(text):
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number") from None
        if not least <= value <= 1_000_000:
            raise argparse.ArgumentTypeError(f"{text} must be between {least} and 1000000")
        return value

    return read


def out_folder(text):
    """An argument type of --out: the whole path of a folder that FreeFEM writes runs into. Raises BadInput."""
    path = Path(text).resolve()
    if not re.fullmatch(r"[A-Za-z0-9._/+=,@%-]+", str(path)):
        raise BadInput(f"--out '{path}' holds signs other than letters, figures and . _ - / + = , @ %, which FreeFEM takes in no "
            f"folder of a run")
    return path


def case_options(words, taken):
    """["-mu", "0.1"] as a dict of a case's options; `taken`: those that the tool sets itself. Raises BadInput."""
    if len(words) % 2 or any(not re.match("-[A-Za-z]", name) for name in words[::2]):
        raise BadInput(f"options of the case come in pairs, -name value; not {' '.join(words)}")
    for name in words[::2]:
        if name in taken:
            raise BadInput(f"{name} is set by this tool, not among the options of the case")
    return dict(zip(words[::2], words[1::2]))


def guarded(main):
    """Run main() and end the process with its status; BadInput becomes one line and status 3,
    SIGTERM and a closed terminal (SIGHUP) end the runs under way as the keyboard does."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_DFL:  # nohup ignores SIGHUP
            signal.signal(number, end)
    try:
        status = main()
        sys.stdout.flush()
        sys.exit(status)
    except BadInput as problem:
        print("error: " + " ".join(str(problem).split()), file=sys.stderr)
        sys.exit(BAD_INPUT)
    except BrokenPipeError:  # the reader of our output has gone (| head)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except OSError as problem:  # no permission, a full disk
        print(f"error: cannot write or read {problem.filename or 'a file'}: {problem.strerror or problem}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    except Ended as problem:
        number = problem.args[0]
        leave(f"stopped by {signal.Signals(number).name}", 128 + number)
    except KeyboardInterrupt:
        leave("stopped by the keyboard", 130)


def leave(line, status):
    """End the process with a line. What had to be cleaned up has been; a thread of gmsh at work would crash an end by sys.exit."""
    with suppress(OSError):  # the terminal may have gone
        print(line, file=sys.stderr, flush=True)
        sys.stdout.flush()
    os._exit(status)


def end(number, _):
    """The answer to a signal that asks the process to end."""
    raise Ended(number)
