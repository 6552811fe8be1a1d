"""The notebook of the page on Python: the same text and code, as cells that Jupyter runs."""
import json
import re

from tools.base.command import ROOT

PAGE, NOTEBOOK = "docs/guide/python.md", "docs/guide/python.ipynb"
FIRST = '''# The notebook may be opened from any folder of the project.
import os
import sys
from pathlib import Path

root = next(folder for folder in (Path.cwd(), *Path.cwd().parents) if (folder / "lib/case.idp").is_file())
os.chdir(root)
sys.path.insert(0, str(root))'''


def cells(page):
    """[(kind, text)] of a page: "code" of its blocks of Python, "markdown" of what stands between them."""
    parts = re.split(r"```python\n(.*?)```", page, flags=re.S)
    found = [("markdown" if k % 2 == 0 else "code", part.strip()) for k, part in enumerate(parts)]
    return [found[0], ("code", FIRST), *(cell for cell in found[1:] if cell[1])]


def pages():
    """{path: text} of the notebook. Its pictures and links are left to the page."""
    written = []
    for number, (kind, text) in enumerate(cells((ROOT / PAGE).read_text())):
        if kind == "markdown":
            text = re.sub(r"!\[[^]]*\]\([^)]*\)", "", text).strip()
        cell = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text.splitlines(keepends=True)}
        written.append(cell | ({"execution_count": None, "outputs": []} if kind == "code" else {}))
    book = {"cells": written, "metadata": {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"}}, "nbformat": 4, "nbformat_minor": 5}
    return {NOTEBOOK: json.dumps(book, indent=1, ensure_ascii=False) + "\n"}
