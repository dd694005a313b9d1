"""Smaller models that fail in the same way. Deterministic, and never more runs of the program than allowed."""

from .collapse import Collapsible
from .complex import Solid, boundary, faces_of, turned
from .judge import FALSE_WITNESS, UNSOLVED
from .kinds import Model
from .surface import faults


class Minimiser:
    def __init__(self, judge, most_runs=200):
        self.judge, self.left = judge, most_runs
        self.smallest = None  # so far

    def minimise(self, model, what):
        """The model, or a smaller one with the same verdict. Its solid goes along where the verdict depends on it; where
        it does not, edges are collapsed once no tet can be left out."""
        self.smallest = model
        ways = [components]
        if model.solid:
            ways += [stars, tets]
        if not model.solid or what not in (FALSE_WITNESS, UNSOLVED):
            ways.append(collapses)
        shrunk = True
        while shrunk and self.left > 0:
            shrunk = False
            for way in ways:
                found = self.shrink(model, what, way)
                shrunk |= found is not model
                model = found
        return model

    def shrink(self, model, what, way):
        """Takes the first smaller model that fails, as long as there is one. Candidates come large steps first."""
        looking = True
        while looking:
            looking = False
            for candidate in way(model):
                if size(candidate) >= size(model) or faults(candidate.surface):
                    continue
                if self.left <= 0:
                    return model
                self.left -= 1
                verdict = self.judge(candidate)
                if verdict.failed and verdict.what == what:
                    model, looking = candidate, True
                    self.smallest = model
                    break
        return model


def size(model):
    return len(model.surface.faces), len(model.solid.tets) if model.solid else 0


def halves(n):
    """n/2, n/4, ... 1."""
    while n > 1:
        n //= 2
        yield n


def components(model):
    """One of several alone, then all but one."""
    parts = model.surface.components()
    if len(parts) < 2:
        return
    for chosen in [[p] for p in parts] + [[q for q in parts if q is not p] for p in parts]:
        if model.solid:
            # The first vertices of the solid are those of the surface. What hangs together with them belongs to it.
            reached = {v for p in chosen for i in p for v in model.surface.faces[i]}
            grew = True
            while grew:
                more = {v for t in model.solid.tets if reached & set(t) for v in t}
                grew = not more <= reached
                reached |= more
            yield from solid_models(model, [t for t in model.solid.tets if t[0] in reached])
        else:
            yield Model(model.surface.only([model.surface.faces[i] for p in chosen for i in p]))


def solid_models(model, tets):
    if tets:
        solid = Solid(model.solid.points, tets)
        if not solid.faults():
            yield Model(solid.surface, solid)


def stars(model):
    """Without all the tets at a vertex."""
    for v in range(len(model.solid.points)):
        yield from solid_models(model, [t for t in model.solid.tets if v not in t])


def tets(model):
    """Without many tets that are taken off one after the other, most faces outside first; then without fewer."""
    everything = model.solid.tets
    for count in [max(1, len(everything) * 3 // 4), *halves(len(everything))]:
        for start in range(0, len(everything), count):
            yield from solid_models(model, peeled(everything, start, count))


def peeled(everything, start, count):
    """Takes off tets with two or three faces outside; from the tet `start` on, in a ring through all of them."""
    left = everything[start:] + everything[:start]
    while count > 0:
        outside = set(boundary(left))
        order = sorted(range(len(left)), key=lambda i: -sum(turned(f) in outside for f in faces_of(left[i])))
        if sum(turned(f) in outside for f in faces_of(left[order[0]])) < 2:
            break
        left.pop(order[0])
        count -= 1
    return left


def collapses(model):
    """With many edges collapsed, short ones first; then with fewer."""
    work = Collapsible(model.surface)
    edges = sorted(work.edges(), key=lambda e: (work.length(*e), e))
    for count in halves(len(edges) // 3):
        for start in range(0, len(edges), count):
            for keep in (0, 1) if count == 1 else (0,):
                work = Collapsible(model.surface)
                for e in edges[start : start + count]:
                    work.collapse(e[keep], e[1 - keep])
                if len(work.faces) < len(model.surface.faces):
                    yield Model(work.surface())
