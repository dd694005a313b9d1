"""What scripts/docs is made of: the sources' links, the references, Sphinx, and a check of the pages."""
