"""Settings of Sphinx, for ``make docs`` and for rosdoc2.

One documentation for all packages, since a reader asks about the loop, not about a package. It
stands in ``docs/source``, one of the two places where rosdoc2 looks, and belongs to the package at
the top: ``src/bdt_bringup/rosdoc2.yaml`` points here. rosdoc2 copies this folder and nothing else,
so everything that the build needs is in it.
"""

import sys
from importlib import metadata
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

from python_packages import PACKAGES, forget_old_pages, package_contents

project = "Backlash digital twin"
author = "Backlash Digital Twin developers"
copyright = author  # noqa: A001 - Sphinx calls it so
try:
    release = metadata.version("bdt_bringup")
except metadata.PackageNotFoundError:  # a build farm documents without installing
    release = ""

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "interface_tables",
    "command_reference",
    "docstring_fields",
    "mathml",
]
# index.rst is rosdoc2's own start page, which it writes beside ours.
exclude_patterns = ["index.rst", "extensions"]
templates_path = ["_templates"]

# Markdown
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 4

# Python packages: a page each, with a section for each of its modules.
autosummary_generate = True
autosummary_context = {"contents": package_contents()}
forget_old_pages(Path(__file__).parent / "reference/api/generated", autosummary_context["contents"])
if not autosummary_context["contents"].keys() >= set(PACKAGES):
    # A build farm has no numpy and no rclpy; there rosdoc2 makes a page of each package by itself.
    # Here it would be a warning, and with `make docs` an error.
    exclude_patterns.append("reference/api")

# Docstrings: numpydoc's types are words for people ("ndarray, shape (n, 3)"), not names to link.
autodoc_member_order = "bysource"
autodoc_typehints = "none"
add_module_names = False
toc_object_entries_show_parents = "hide"
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
napoleon_custom_sections = [("Attributes", "params_style")]

# Every reference into our packages must resolve; those of numpy and rclpy would need a download.
nitpicky = True
nitpick_ignore_regex = [("py:.*", r"(?!bdt_).*")]

# Pages
html_theme = "furo"
html_math_renderer = "mathml"
html_title = project
html_static_path = ["static"]
html_css_files = ["wide_tables.css"]
copybutton_prompt_text = r"\$ |> "
copybutton_prompt_is_regexp = True
copybutton_line_continuation_character = "\\"

rosdoc2_settings = {"allow_other_extensions": True, "override_theme": False}
