"""python -m tools.run, or python FOLDER_OF_THE_PROJECT/tools/run.py: runs a case from any folder (tools/compile_errors/run.py)."""
import sys
from pathlib import Path

if not __package__:  # started by its path
    sys.path[0] = str(Path(__file__).resolve().parent.parent)

from tools.base.command import guarded  # noqa: E402
from tools.compile_errors.run import main  # noqa: E402

if __name__ == "__main__":
    guarded(main)
