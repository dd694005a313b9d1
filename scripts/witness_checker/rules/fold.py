"""Rule `fold`: a vertex whose B0 is negative, where two faces lie flat on each other or almost.

{"rule": "fold", "vertices": [v], "B0": [b]}

The proof is that of `vertex.py`. Programs that round angles cannot tell a full turn from none there; signs of integers
can. Two faces exactly on each other are a full turn: tets at their edge leave no room for less.
"""

from .vertex import check

__all__ = ["check"]
