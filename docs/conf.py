"""How is the site built? ``python -m sphinx -W -b html docs docs/_build/html``, with ``.[docs]`` installed.

Commands on the pages run while it is built, in folders of their own under docs/_made (``_ext/executed.py``). Pictures
of the gallery come from the studies' coarse runs: those of the folder that SITS_DOCS_STUDIES names, or made here.
"""

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))
sys.argv[0] = "sits-mech"  # by which cyclopts names the program of its pages
for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

(HERE / "_made" / "extra").mkdir(parents=True, exist_ok=True)
from sits_mech.version import __version__  # noqa: E402

project = "sits-mech"
author = "the authors of sits-mech"
copyright = "the authors of sits-mech"
version = release = __version__
extensions = [
    "cyclopts.ext.sphinx", "myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton",
    "sphinx_design", "site_parts",
]
_INCLUDED = (
    "answer_keys", "bench_headings", "benchmarks", "laws", "left_out", "numbers", "requirement_keys", "scene_keys",
    "studies_grid", "study_keys",
)  # in other pages
exclude_patterns = ["_build", "_made", *(f"_pages/{name}.md" for name in _INCLUDED)]
nitpicky = False
smartquotes = False  # commands and quantities are copied from pages
html_theme = "furo"
html_title = "sits-mech"
html_static_path = ["_static"]
html_css_files = ["style.css"]
html_extra_path = ["_made/extra"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sourcelink = False
html_baseurl = ""
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True
copybutton_line_continuation_character = "\\"
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_use_rtype = False
napoleon_use_ivar = True
pygments_style = "tango"
linkcheck_anchors = False
linkcheck_timeout = 15
linkcheck_allowed_redirects = {r"https://doi\.org/.*": r".*"}
