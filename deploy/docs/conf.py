"""Sphinx's settings for the Python reference, made by deploy/reference; warnings are errors.

A name of the package that index.rst leaves out is a warning, and so are a member without a docstring
and a docstring that does not name a parameter.
"""
import importlib
import inspect
import pathlib
import re
import sys

from sphinx.util import logging

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "client/python"))

project = "dynmesh"
release = version = ".".join(re.findall(
    r"^#define DYNMESH_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$",
    (SOURCE / "core/include/dynmesh/version.h").read_text(), re.M))
author = copyright = "the dynmesh authors"  # noqa: A001: Sphinx's name
extensions = ["sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "alabaster"
html_theme_options = {"nosidebar": False, "page_width": "1100px"}
html_show_sourcelink = False
html_copy_source = False
default_role = "code"

# The sources alone are read: nothing has to be built.
autodoc_mock_imports = ["dynmesh._core", "dynmesh._service", "numpy"]
autodoc_default_options = {"members": True, "undoc-members": True, "show-inheritance": True}
autodoc_member_order = "bysource"
autodoc_type_aliases = {"Array": "Array", "Kind": "Kind", "Pem": "Pem", "Progress": "Progress"}
napoleon_google_docstring = True
napoleon_numpy_docstring = False

WITH_SIGNATURE = ("dynmesh.Series", "dynmesh.compat.meshpy.tet.Options", "dynmesh.compat.tetgen.TetGen")
# Those of whose names index.rst has all.
MODULES = ("dynmesh", "dynmesh.compat", "dynmesh.compat.triangle",
           "dynmesh.compat.meshpy.triangle", "dynmesh.compat.meshpy.tet", "dynmesh.compat.tetgen")

_log = logging.getLogger(__name__)


def _check(app, what, name, thing, options, lines):
    text = "\n".join(lines)
    if not text.strip():
        _log.warning("%s has no docstring", name)
    if what in ("attribute", "property"):
        # Napoleon takes what stands before a colon in the first line for a type: an empty comment.
        lines[:0] = ["..", ""]
    if what not in ("function", "method"):
        return
    words = set(re.findall(r"\w+", text))
    for parameter in inspect.signature(thing).parameters:
        if parameter != "self" and parameter not in words:
            _log.warning("the docstring of %s does not name its parameter %s", name, parameter)


def _hide(app, what, name, thing, options, signature, returns):
    """Of a class what its constructor takes, unless index.rst says it: most are made by functions."""
    return ("", None) if what == "class" and name not in WITH_SIGNATURE else None


def _check_names(app, environment):
    documented = environment.get_domain("py").objects
    for module in MODULES:
        for name in importlib.import_module(module).__all__:
            if f"{module}.{name}" not in documented:
                _log.warning("index.rst does not have %s.%s", module, name)


def setup(app):
    # Before napoleon, which takes the names of arguments apart.
    app.connect("autodoc-process-docstring", _check, priority=100)
    app.connect("autodoc-process-signature", _hide)
    app.connect("env-check-consistency", _check_names)
