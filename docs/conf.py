"""How the documentation is built: ``sphinx-build -W -c docs . build/docs``, from the root of a checkout.

The source folder is the checkout itself, so that links between the documentation, the results and the code are the
same on this site and wherever else the files are read.
"""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "docs" / "extensions")]

project, author = "tracer", "the authors of tracer"
release = installed_version("mitsuba-tracer")
extensions = [
    "myst_nb",  # pages in Markdown, and notebooks, which are run
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",  # runs the examples, and shows the pictures that they make
    "class_names",
    "command_pages",
    "keyword_lists",
    "plugin_pages",
    "criterion_pages",
]
root_doc = "docs/index"
include_patterns = ["docs/**", "results/*/results.md", "examples/**.ipynb", "scenes/README.md"]
exclude_patterns = ["docs/extensions", "docs/gallery/**.ipynb", "docs/gallery/**.py", "examples/README.rst"]
source_suffix = {".md": "myst-nb", ".rst": "restructuredtext", ".ipynb": "myst-nb"}

html_theme = "furo"
html_title = "tracer"
html_static_path = ["static"]
html_css_files = ["tracer.css"]
html_extra_path = ["root"]
html_copy_source = False
html_show_copyright = False
smartquotes = False  # options begin with two hyphens
templates_path: list[str] = []

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = ["myst.header"]  # tables of results begin below a line, not below a title
if tags.has("links"):  # noqa: F821  # type: ignore[name-defined]
    # Texts that are no pages of the site have links to follow, too.
    include_patterns += ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"]
    suppress_warnings += ["toc.not_included", "myst.xref_missing"]
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_execution_excludepatterns = ["docs/**"]

autodoc_typehints_format = "short"
autodoc_type_aliases = {"ArrayLike": "ArrayLike"}  # else it is spelt out, in three lines
autodoc_member_order = "bysource"
python_maximum_signature_line_length = 80

sphinx_gallery_conf = {
    "examples_dirs": ["examples"],
    "gallery_dirs": ["docs/gallery"],
    "filename_pattern": r"/[a-z_]+\.py$",
    "ignore_pattern": r"__init__\.py",
    "within_subsection_order": "gallery_order.Order",
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "write_computation_times": False,
    "min_reported_time": 30,
    "abort_on_example_error": True,
    "reset_modules": ("matplotlib",),
    "copyfile_regex": r".*\.(svg|png)",
}
