"""The rules: why there can be no mesh, a module each. `check(surface, witness)` returns what has been confirmed, as a
sentence, or raises one of `errors.py`."""
