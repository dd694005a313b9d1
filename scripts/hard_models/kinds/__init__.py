"""Kinds of models. A kind is a function from random numbers to a surface, or to a solid whose surface is the model."""

from .. import overlap
from ..complex import Solid
from ..errors import NoModel
from ..seeds import source_of
from ..surface import faults
from . import built, deformed

DEFORMED = {f.__name__: f for f in (deformed.bend, deformed.poke, deformed.pose, deformed.wave, deformed.decimate,
                                    deformed.scale)}
BUILT = {f.__name__: f for f in (built.grown, built.lattice, built.tunnels, built.fan, built.blocks, built.shaken,
                                 built.cake, built.welded, built.copies, built.needles, built.affine)}
ALL = {**DEFORMED, **BUILT}
ATTEMPTS = 60


class Model:
    """A surface, and the solid that proves that it has a mesh, or None. A surface from a file may be known to have
    a mesh all the same."""

    def __init__(self, surface, solid=None, has_mesh=False):
        self.surface, self.solid, self.has_mesh = surface, solid, has_mesh or solid is not None


def make(kind, number):
    """The model of this number: the first that its random numbers lead to, and that passes through itself if it is built
    from tets."""
    for attempt in range(ATTEMPTS):
        try:
            made = ALL[kind](source_of(kind, number, attempt))
        except NoModel:
            continue
        model = Model(made.surface, made) if isinstance(made, Solid) else Model(made)
        wrong = faults(model.surface) or (model.solid and model.solid.faults())
        if wrong:
            raise AssertionError(f"{kind} {number}: {wrong}")
        if model.solid is None or overlap.overlaps(model.solid):
            return model
    raise NoModel(f"{kind} {number}: no model in {ATTEMPTS} attempts")
