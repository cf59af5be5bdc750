"""How Sphinx makes the site of these pages; ``scripts/docs`` calls it.

It reads a copy of this folder that has ``examples`` and the project's own pages beside it, so that
nothing that is made lands among what is written.
"""

import os
import re
import runpy
import warnings
from importlib.metadata import metadata
from pathlib import Path

import matplotlib.pyplot as plt
from sphinx_gallery.scrapers import figure_rst

HERE = Path(__file__).resolve().parent
QUICK = os.environ.get("TRACKWEAVE_DOCS") == "quick"

project = "trackweave"
author = "trackweave developers"
copyright = "trackweave developers"
version = release = metadata("trackweave")["Version"]

# How NumPy writes the type of an array; shapes and units stand in the text.
ARRAY = re.compile(r"numpy\.ndarray\[tuple\[.*?\], numpy\.dtype\[.*?\]\]")
# What stands under "Returns", up to an empty line.
RETURNED = re.compile(
    r"^((?:Returns|Yields)\n-+\n)(.+?)(?=\n\s*\n|\s*\Z)", re.MULTILINE | re.DOTALL
)
# The gallery's topics and their examples, in the order in which they are shown.
GALLERY = {
    "tracking": (
        "crossing", "nothing_told", "smoothing", "live", "turning", "heavy_tails", "silences",
        "study",
    ),
    "sensors": ("radar_evening", "ships", "ghosts", "learned_coverage", "bias"),
    "images": ("people", "boxes", "cells", "particles"),
    "association": ("three_lists", "gap", "jpda", "pmx", "patent", "ants"),
    "beyond": ("stone_soup", "own_motion", "formats"),
}  # fmt: skip


def picture_of(block, block_vars, gallery_conf):
    """Take the picture that an example saves as ``figure``, whatever made it."""
    if "figure.savefig(" not in block[1]:
        return ""
    figure = block_vars["example_globals"]["figure"]
    path = next(block_vars["image_path_iterator"])
    with warnings.catch_warnings():
        # The library's own pictures lay themselves out.
        warnings.filterwarnings("ignore", message="There are no gridspecs")
        figure.savefig(path, dpi=120, bbox_inches="tight")
    return figure_rst([path], gallery_conf["src_dir"])


def look(gallery_conf, name):
    """Let every example begin with the same quiet look, and none with another's."""
    plt.close("all")
    plt.rcdefaults()
    plt.rcParams.update({
        "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
        "grid.alpha": 0.25, "figure.figsize": (8.0, 4.8), "figure.constrained_layout.use": True,
        "legend.frameon": False, "axes.titlesize": 11,
    })  # fmt: skip


def place(example):
    """Return where an example comes among those of its topic."""
    return [name for names in GALLERY.values() for name in names].index(Path(example).stem)


def plainer(*told):
    """Let sources be plain items, as a summary has no place for footnotes, and arrays arrays."""
    lines = told[-1]
    for row, line in enumerate(lines):
        sourced = re.sub(r" ?\[(\d)\]_", r" [\1]", line)
        lines[row] = ARRAY.sub("array", re.sub(r"^\.\. \[(\d)\] ", r"-  [\1] ", sourced))


extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
templates_path = ["_templates"]
exclude_patterns = ["gallery/README.rst", "**/sg_execution_times.rst", "sg_execution_times.rst"]
default_role = "code"
# Every heading can be linked to, as Markdown's readers elsewhere have it.
myst_heading_anchors = 4
suppress_warnings = [
    # A page may use levels of headings as it needs them.
    "myst.header",
    # The configuration holds a function: it is read anew each time.
    "config.cache",
]

autosummary_generate = True
autosummary_imported_members = True
autosummary_ignore_module_all = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_class_signature = "mixed"
# Sections of a docstring become fields; "Examples" stay what they are.
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
add_module_names = False
python_use_unqualified_type_names = True

html_theme = "pydata_sphinx_theme"
html_title = "trackweave"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_extra_path = ["_extra"]
html_show_sourcelink = False
html_copy_source = False
# Public addresses, where there are any, stand in pyproject.toml alone.
urls = dict(entry.split(", ", 1) for entry in metadata("trackweave").get_all("Project-URL") or ())
html_theme_options = {
    "icon_links": [
        {"name": name, "url": url, "icon": "fa-solid fa-link"} for name, url in urls.items()
    ],
    "show_prev_next": False,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "header_links_before_dropdown": 6,
    "footer_start": ["copyright"],
    "footer_end": ["theme-version"],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "plot_gallery": not QUICK,
    "filename_pattern": r"\.py$",
    "subsection_order": [f"../examples/gallery/{name}" for name in GALLERY],
    "within_subsection_order": place,
    "abort_on_example_error": True,
    "image_scrapers": (picture_of,),
    "reset_modules": (look,),
    "capture_repr": (),
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "thumbnail_size": (400, 280),
    "remove_config_comments": True,
}

linkcheck_timeout = 20
linkcheck_ignore = [r"http://127\.0\.0\.1.*", r"http://localhost.*"]


def lead_into_the_site(app, name, source):
    """Let links to examples lead to their pages, and those to folders be words alone."""
    folder = (HERE / name).parent

    def new(link):
        text, target = link[1], link[2]
        if target.startswith("#"):
            return link[0]
        path = (folder / target.partition("#")[0]).resolve()
        gallery = HERE.parent / "examples" / "gallery"
        if path.is_relative_to(gallery) and path.suffix == ".py":
            up = "../" * (len(folder.relative_to(HERE).parts))
            return f"[{text}]({up}gallery/{path.relative_to(gallery).with_suffix('.rst')})"
        if path == gallery:
            return f"[{text}]({'../' * len(folder.relative_to(HERE).parts)}gallery/index.rst)"
        if path.is_dir():
            return text
        return link[0]

    if Path(app.env.doc2path(name)).suffix == ".md":
        source[0] = re.sub(r"(?<!!)\[([^\]\n]*)\]\(([^)\s:]+)\)", new, source[0])


def untyped(*told):
    """Let what stands before a colon in an attribute's sentence be of the sentence, no type."""
    what, lines = told[1], told[-1]
    if what in {"attribute", "data", "property"} and lines and ":" in lines[0]:
        lines[0] = f": {lines[0]}"


def joined(*told):
    """Let what is returned stand on one line: Napoleon takes each of its lines for an item."""
    told[-1][:] = RETURNED.sub(
        lambda found: found[1] + found[2].replace("\n", " "), "\n".join(told[-1])
    ).split("\n")


def box_tables(app, name, template, context, tree):
    """Let long tables of explanations scroll in themselves; elsewhere the table is the page."""
    if name.startswith("explanation/") or name == "performance":
        app.add_css_file("boxes.css")


def begin_with_pictures(app, name, source):
    """Let a page that names examples as its pictures begin with these pictures."""
    said = re.search(r"In (?:a picture|pictures): .*?(?=\n\n)", source[0], re.DOTALL)
    example = re.compile(r"\[([^\]]*)\]\([^)]*examples/gallery/(\w+)/(\w+)\.py\)")
    links = example.findall(said[0]) if said else []
    if QUICK or not links:
        return
    up = "../" * name.count("/") + "gallery"
    row = "\n".join(
        f"[![{text}]({up}/{topic}/images/sphx_glr_{example}_001.png)]({up}/{topic}/{example}.rst)"
        for text, topic, example in links[:3]
    )
    title, rest = source[0].split("\n", 1)
    source[0] = f"{title}\n\n```{{container}} pictures\n{row}\n```\n{rest}"


def setup(app):
    """Register what is ours, and write the page that the code makes."""
    page = runpy.run_path(str(HERE / "every_key.py"))["page"]
    (HERE / "reference" / "every-key.md").write_text(page())
    # Before links lead into the site: by examples' own paths they are known.
    app.connect("source-read", begin_with_pictures)
    app.connect("source-read", lead_into_the_site)
    app.connect("html-page-context", box_tables)
    # Before Napoleon, which takes what stands before a colon for a type.
    app.connect("autodoc-process-docstring", untyped, priority=400)
    app.connect("autodoc-process-docstring", joined, priority=400)
    app.connect("autodoc-process-docstring", plainer)


# "On this page" has no room for a class before each of its methods.
toc_object_entries_show_parents = "hide"
