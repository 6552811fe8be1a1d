"""How Sphinx builds these pages: make docs."""
import importlib.util
import re
from pathlib import Path

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform

ROOT = Path(__file__).resolve().parent.parent

project = "Rigid particles in flows"
author = "The authors"
version = release = re.search(r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), flags=re.M).group(1)
html_title = f"{project} {version}"

extensions = ["myst_parser", "sphinx.ext.mathjax"]
myst_enable_extensions = ["amsmath", "attrs_block", "attrs_inline", "colon_fence", "dollarmath"]
myst_heading_anchors = 4
exclude_patterns = ["requirements.txt"]
suppress_warnings = ["misc.highlighting_failure"]  # FreeFEM's language is close to C++, not the same
highlight_language = "text"

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True}

# The pages are read from a folder, often without a network: MathJax is a file beside them.
mathjax_path = "tex-svg.js"
html_static_path.append(str(Path(importlib.util.find_spec("sphinx-mathjax-offline").origin).parent / "static/mathjax/tex-svg.js"))


class Together(SphinxPostTransform):
    """Keeps a number and its unit, the parts of 1e-4 and 2D-2, and the words of short code in one line."""
    default_priority = 900

    def run(self, **kwargs):
        for code in self.document.findall(nodes.literal):
            if max(map(len, code.astext().split()), default=0) <= 14:
                code["classes"].append("short")
        for text in list(self.document.findall(nodes.Text)):
            if isinstance(text.parent, (nodes.literal, nodes.literal_block, nodes.math, nodes.math_block, nodes.raw)):
                continue
            joined = re.sub(r"(?<=\d) (?=(?:%|[mcn]?m|m?s|m/s|rad/s|Pa|N/m|D/U|[kMG]i?B|H)(?!\w))", "\N{NO-BREAK SPACE}", text)
            joined = re.sub(r"(?<=\w-)(?=\d)", "\N{WORD JOINER}", joined)
            if joined != text:
                text.parent.replace(text, nodes.Text(joined))


def setup(app):
    app.add_post_transform(Together)
