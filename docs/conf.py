"""Settings of the documentation: furo, MyST, executed examples, API pages from docstrings."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))  # offline_math

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "Agg")

from docutils import nodes
from sphinx.addnodes import pending_xref

import ocp_traj

project = "ocp-traj"
author = "ocp-traj developers"
copyright = "2026, ocp-traj developers"
version = release = ocp_traj.__version__

extensions = [
    "myst_parser",
    "offline_math",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "sphinxcontrib.bibtex",
]
exclude_patterns = ["_build"]
suppress_warnings = ["config.cache"]  # the gallery keeps functions in its settings

# References to errors, functions and our own classes have to lead somewhere; types in words and those of other
# packages, which no page without a network can link to, do not.
nitpicky = True
nitpick_ignore_regex = [
    ("py:class", r"(?!ocp_traj\.|metaheuristics\.).*"),
    ("py:class", r"metaheuristics\.optimizer\.(Frame|StateT)"),
]

html_theme = "furo"
html_title = f"ocp-traj {release}"
html_show_sourcelink = False
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["pages.css"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

bibtex_bibfiles = ["references.bib"]

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_default_options = {"members": True}
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_preprocess_types = False

copybutton_exclude = ".linenos, .gp, .go"
copybutton_prompt_text = "$ "

READING_ORDER = (
    "first_motion",
    "virtual_knots",
    "torque_limits",
    "time_against_energy",
    "plot_pareto_front",
    "smoothness",
    "moving_ends",
    "waypoint_tolerances",
    "cartesian_helix",
    "your_own_urdf",
    "dh_robot",
    "gradient_against_swarms",
    "references",
    "proof",
    "published_result",
    "export_to_ros2",
    "scale_out_with_dask",
    "own_objective_and_limit",
    "own_solver",
    "own_family",
)


class ReadingOrder:
    """Sorts the examples from the first motion to extensions; those not named come last."""

    def __init__(self, folder: str) -> None:
        self.folder = folder

    def __call__(self, file: str) -> tuple[int, str]:
        stem = file.removesuffix(".py")
        place = READING_ORDER.index(stem) if stem in READING_ORDER else len(READING_ORDER)
        return place, stem


sphinx_gallery_conf = {
    "within_subsection_order": ReadingOrder,
    "examples_dirs": "../examples",
    "gallery_dirs": "auto_examples",
    "filename_pattern": r".*",
    "abort_on_example_error": False,
    "only_warn_on_example_error": False,
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "write_computation_times": False,
    "plot_gallery": os.environ.get("OCP_TRAJ_DOCS_EXAMPLES", "1") == "1",
}


def keep_bars(app: Any, what: str, name: str, subject: object, options: object, lines: list[str]) -> None:
    """Escape the bars of absolute values: reStructuredText takes ``|x|`` for a substitution."""
    for index, line in enumerate(lines):
        parts = re.split(r"(``.*?``)", line)
        lines[index] = "".join(part if part.startswith("``") else part.replace("|", r"\|") for part in parts)


def unlink_words(app: Any, doctree: nodes.document) -> None:
    """Take links from the words of types: ``(n,) array`` has nothing to do with an attribute called ``n``."""
    for node in list(doctree.findall(pending_xref)):
        target = node.get("reftarget", "").rpartition(".")[2]
        if node.get("refdomain") == "py" and node.get("reftype") == "class" and not target[:1].isupper():
            node.replace_self(node.children)


def setup(app: Any) -> None:
    """Register what this file adds to Sphinx."""
    app.connect("doctree-read", unlink_words)
    app.connect("autodoc-process-docstring", keep_bars, priority=100)
