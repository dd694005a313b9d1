"""How Sphinx builds the site; scripts/docs calls it."""
project = "Overtet"
author = "Overtet contributors"
copyright = "Overtet contributors; AGPL-3.0-or-later"  # noqa: A001
extensions = ["myst_parser"]
root_doc = "index"
exclude_patterns = ["examples"]
html_theme = "furo"
html_title = "Overtet"
html_copy_source = False
html_show_sourcelink = False
html_baseurl = ""
myst_heading_anchors = 4
myst_enable_extensions = ["deflist", "colon_fence"]
smartquotes = False  # options begin with two hyphens
nitpick_ignore_regex = [("py:.*", ".*")]  # bases of Python's own, as Exception
highlight_language = "text"
add_module_names = False
