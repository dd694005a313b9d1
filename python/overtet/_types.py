"""What goes in and comes out: dataclasses of numpy arrays. All of them can be pickled and copied."""
from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from . import _arrays

Names = Dict[int, str]
Data = Dict[str, np.ndarray]


def _shape(thing: Any) -> str:
    return "none" if thing is None else " x ".join(map(str, np.shape(thing)))


@dataclass(eq=False)
class Surface:
    """A triangle surface, with what a file says of it.

    V: #V x 3 coordinates; F: #F x 3 vertices, counter-clockwise seen from outside. labels, solids: #F whole numbers,
    or None, with names of some of the numbers. vertex_data, face_data: name -> array of #V or #F rows. input_vertex,
    input_face: the numbers that vertices and faces have in the file, None: the same. Everything counts from 0.
    """

    V: np.ndarray
    F: np.ndarray
    labels: Optional[np.ndarray] = None
    label_names: Names = field(default_factory=dict)
    solids: Optional[np.ndarray] = None
    solid_names: Names = field(default_factory=dict)
    vertex_data: Data = field(default_factory=dict)
    face_data: Data = field(default_factory=dict)
    input_vertex: Optional[np.ndarray] = None
    input_face: Optional[np.ndarray] = None
    format: str = ""  #: what file it was read from, for instance "OFF"
    notes: List[str] = field(default_factory=list)  #: what reading it has to say, sentence by sentence
    has_vertex_order: bool = True  #: False: the file (STL) lists corners only, so verify compares coordinates

    def __repr__(self) -> str:
        return f"Surface({len(self.V)} vertices, {len(self.F)} faces)"


def surface_dict(surface: Surface) -> dict:
    """What _core takes; raises UsageError where arrays do not fit each other."""
    V, F = _arrays.points(surface.V), _arrays.elements(surface.F, "F", 3)
    n, m = len(V), len(F)
    return {"V": V, "F": F,
            "labels": _arrays.integers(surface.labels, "labels", m, "face"), "label_names": dict(surface.label_names),
            "solids": _arrays.integers(surface.solids, "solids", m, "face"), "solid_names": dict(surface.solid_names),
            "vertex_data": _arrays.data(surface.vertex_data, "vertex_data", n, "vertex"),
            "face_data": _arrays.data(surface.face_data, "face_data", m, "face"),
            "input_vertex": _arrays.integers(surface.input_vertex, "input_vertex", n, "vertex"),
            "input_face": _arrays.integers(surface.input_face, "input_face", m, "face")}


@dataclass(eq=False)
class Quality:
    """Figures of a tet mesh; angles in degrees."""

    tets: int
    dihedral_min: float
    dihedral_p01: float  #: 1 % of the angles are smaller
    dihedral_max: float
    volume: float  #: sum over the tets, overlaps counted each time
    coincident_vertices: int  #: exactly in one place with another one
    closest_pair: float  #: the smallest distance of two vertices over the diagonal
    closest: Tuple[int, int]


@dataclass(eq=False)
class Mesh:
    """A tet mesh, with where everything comes from. Everything counts from 0.

    V: #V x 3 coordinates, float64; the surface's vertices come first, in their order, to the bit. T: #T x 4 vertices,
    int32; det(b - a, c - a, d - a) > 0. boundary: #B x 3, the boundary faces, as the surface has them.
    boundary_face: #B, the surface's face (its number in the file where Surface.input_face knows it). labels: #B, as
    given, else the surface's components, counted from 1. regions: #T, which solid a tet belongs to. layers: #T, how
    many layers of the solid there are at the tet's centre, or None. input_vertex: #V, the surface's vertex, -1: an
    inner one.
    """

    V: np.ndarray
    T: np.ndarray
    boundary: Optional[np.ndarray] = None
    boundary_face: Optional[np.ndarray] = None
    labels: Optional[np.ndarray] = None
    label_names: Names = field(default_factory=dict)
    regions: Optional[np.ndarray] = None
    region_names: Names = field(default_factory=dict)
    layers: Optional[np.ndarray] = None
    input_vertex: Optional[np.ndarray] = None
    vertex_data: Data = field(default_factory=dict)  #: name -> array of #V rows
    triangle_data: Data = field(default_factory=dict)  #: name -> array of #B rows
    surface_vertices: int = 0  #: so many rows of V are the surface's (0 where the mesh was read from a file)
    status: str = ""  #: "exact", "repaired", "refined" or "branched"
    moved: Optional[np.ndarray] = None  #: vertices that a repair has moved, sorted
    max_relative_move: float = 0.0  #: the largest move over the diagonal of the bounding box
    branch_edges: Optional[np.ndarray] = None  #: #E x 2: of "branched", where tets make two turns or more
    subdivided_faces: Optional[np.ndarray] = None  #: of "refined": faces of the input that are in pieces, sorted
    quality: Optional[Quality] = None
    report: Optional[dict] = None  #: what the run did; docs/report.schema.json has the keys
    hash: str = ""  #: of V and T, 16 hexadecimal digits

    def __repr__(self) -> str:
        return f"Mesh({len(self.V)} vertices, {len(self.T)} tets{', ' + self.status if self.status else ''})"

    @property
    def surface(self) -> Surface:
        """The surface that the mesh is of: the input, repaired or refined where that was asked for."""
        if self.boundary is None:
            raise ValueError("This mesh has no boundary triangles.")
        n = self.surface_vertices or int(self.boundary.max(initial=-1)) + 1
        return Surface(self.V[:n], self.boundary, self.labels, dict(self.label_names))

    def to_meshio(self) -> Any:
        """As a meshio.Mesh: cells "tetra" and "triangle"; cell data "region", "label", "layers", "boundary_face" (-1
        or 0 where the other kind of cell has it) and "gmsh:physical"; point data "input_vertex" and vertex_data;
        names as field_data. Needs meshio."""
        from ._convert import to_meshio
        return to_meshio(self)

    def to_vtk(self) -> Any:
        """As a vtkUnstructuredGrid of the tets, with cell data "region" and "layers" and point data. Needs VTK."""
        from ._convert import to_vtk
        return to_vtk(self)


def mesh_dict(mesh: Mesh, strict: bool = True) -> dict:
    """What _core takes. strict: numbers of vertices must be in range, too."""
    V, T = _arrays.points(mesh.V), _arrays.elements(mesh.T, "T", 4)
    boundary = None if mesh.boundary is None else _arrays.elements(mesh.boundary, "boundary", 3)
    n, t, b = len(V), len(T), 0 if boundary is None else len(boundary)
    if strict:
        _arrays.check_range(T, n, "T")
        if boundary is not None:
            _arrays.check_range(boundary, n, "boundary")

    def of(key: str, count: int, what: str) -> Optional[np.ndarray]:
        return _arrays.integers(getattr(mesh, key), key, count, what)

    labels, faces = of("labels", b, "boundary face"), of("boundary_face", b, "boundary face")
    if boundary is not None:  # the files need both
        labels = np.zeros(b, np.int32) if labels is None else labels
        faces = np.arange(b, dtype=np.int32) if faces is None else faces
    return {"V": V, "T": T, "surface_vertices": int(mesh.surface_vertices), "boundary": boundary,
            "boundary_face": faces, "labels": labels, "label_names": dict(mesh.label_names),
            "regions": of("regions", t, "tet"), "region_names": dict(mesh.region_names),
            "layers": of("layers", t, "tet"), "input_vertex": of("input_vertex", n, "vertex"),
            "vertex_data": _arrays.data(mesh.vertex_data, "vertex_data", n, "vertex"),
            "triangle_data": _arrays.data(mesh.triangle_data, "triangle_data", b, "boundary face")}


@dataclass(eq=False)
class Diagnosis:
    """What is known of a surface before any mesh is made. Exact: verdict, pairs, hinges, winding numbers.

    verdict: "bad-input", "embedded", "feasible" or "infeasible". bool(diagnosis): whether a mesh is not ruled out.
    """

    verdict: str
    message: str  #: one sentence: why
    certificate: Optional[dict]  #: of "infeasible": the proof
    explanation: str  #: the proof in a sentence
    advice: List[str]
    vertices: int
    faces: int
    closed: bool
    manifold: bool
    oriented: bool
    problems: List[str]  #: of the topology, the first of each kind
    components: List[dict]  #: faces, vertices, genus, signed_volume of each
    degenerate_faces: np.ndarray  #: faces without area
    pairs: np.ndarray  #: #P x 2: faces that intersect, sorted
    pairs_sharing_vertex: int
    pairs_sharing_edge: int
    winding_min: Optional[int]
    winding_max: Optional[int]
    hinges: List[dict]  #: vertex, B0, covering, crossings, edges of each vertex whose surroundings cross themselves
    wound_edges: np.ndarray  #: #E x 3: a boundary edge's vertices, and how many turns more it needs
    odd_groups: List[List[int]]
    crowded: np.ndarray
    unfillable: np.ndarray
    unmet: np.ndarray
    curves: List[dict]  #: points (#N x 3), faces (#S x 2), winding (#S x 2), closed, length, ... of each
    thin_spots: List[dict]
    thin_limit: float

    def __bool__(self) -> bool:
        return self.verdict in ("embedded", "feasible")

    def __repr__(self) -> str:
        return f"Diagnosis({self.verdict}: {self.message})"


@dataclass(eq=False)
class Verification:
    """bool(verification): whether the tet mesh is what Overtet promises for the surface.

    failures: rule ("R1" to "R7"), message, count and the first elements of each, in the order of the rules.
    """

    failures: List[dict]
    surface_vertices: int
    surface_faces: int
    vertices: int
    tets: int
    boundary_faces: int
    moved_vertices: int
    max_move: float  #: relative to the diagonal
    branch_edges: np.ndarray  #: #E x 2, with allow_branches
    quality: Optional[Quality]  #: None where indices are out of range

    def __bool__(self) -> bool:
        return not self.failures

    def __repr__(self) -> str:
        return f"Verification({'; '.join(f['message'] for f in self.failures) or 'every rule holds'})"


@dataclass(eq=False)
class Repair:
    """A surface that has a tet mesh, near one that has none: V (#V x 3), F (the same faces), and what was moved."""

    V: np.ndarray
    F: np.ndarray
    moved: np.ndarray  #: vertices, sorted; all others are as they were, to the bit
    max_relative_move: float  #: over the diagonal of the bounding box
    mean_relative_move: float  #: of those that moved
    report: dict

    def __repr__(self) -> str:
        return f"Repair({len(self.moved)} of {len(self.V)} vertices moved)"


@dataclass(eq=False)
class Embedding:
    """The same triangles with nearly the same lengths and areas, intersecting nowhere: V (#V x 3), F (the same faces).

    area, edge: what faces and edges have of their areas and lengths: "least", "p01", "p50", "p99" (1, 50 and 99 %),
    "most".
    """

    V: np.ndarray
    F: np.ndarray
    moved: np.ndarray  #: vertices, sorted; all others are where they were, to the bit
    laid_aside: np.ndarray  #: components that cross others and were moved as a whole, numbered by their first faces
    area: dict
    edge: dict
    area_within_20: float  #: share of the faces whose area is from .8 to 1.2 times the input's
    collapsed: bool  #: a hundredth of the faces has less than a tenth of its area
    report: dict

    def __repr__(self) -> str:
        return (f"Embedding({len(self.moved)} of {len(self.V)} vertices moved, areas {self.area['p01']:.3f} to "
                f"{self.area['p99']:.3f} times)")


@dataclass(eq=False)
class CleanUp:
    """A cleaned surface, and what was done. No coordinate is computed.

    surface: with all that the given one had. vertex_of (#V), face_of (#F): the given surface's number of each vertex
    and face.
    """

    surface: Surface
    vertex_of: np.ndarray
    face_of: np.ndarray
    turned: np.ndarray  #: faces whose last two corners changed places, sorted
    merged: np.ndarray  #: #M x 2: a vertex of the given surface that is gone, and the one that it became
    defects: List[dict]  #: kind, mended, count, message, places of what was found
    changed: bool
    summary: str  #: one line that says what was done; empty where nothing was

    @property
    def V(self) -> np.ndarray:
        return self.surface.V

    @property
    def F(self) -> np.ndarray:
        return self.surface.F

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.surface!r}: {self.summary or 'nothing to do'})"


@dataclass(eq=False, repr=False)
class Prepared(CleanUp):
    """A surface that steps have changed in shape. vertex_of and face_of are -1 at what is new."""

    steps: List[dict] = field(default_factory=list)  #: step, done, left, figures, places, message of each
    moved: np.ndarray = field(default_factory=lambda: np.empty(0, np.int32))  #: vertices that moved, sorted
    remaining: List[dict] = field(default_factory=list)  #: what is wrong still; empty: closed, oriented, manifold

    def __repr__(self) -> str:
        wrong = self.remaining[0]["message"] if self.remaining else "closed, oriented, manifold"
        return f"Prepared({self.surface!r}: {wrong})"


def quality_of(figures: Optional[dict]) -> Optional[Quality]:
    return None if figures is None else Quality(**figures)


def clean_up_of(kind: type, given: Surface, made: dict, **more: Any) -> Any:
    """A CleanUp or Prepared of what _core gives."""
    record = made.pop("record")
    surface = dataclasses.replace(given, V=record.pop("V"), F=record.pop("F"), **made)
    for key, count in (("vertex_of", len(surface.V)), ("face_of", len(surface.F))):
        if record[key] is None:
            record[key] = np.arange(count, dtype=np.int32)
    return kind(surface=surface, **record, **more)


@dataclass(eq=False)
class Field:
    """A field on a tet mesh.

    nodes: #N x 3, the mesh's vertices and, of order 2, the middles of its edges, which follow them. values: #N. energy: the
    integral of |grad u|^2 / 2. residual: of the linear system, relative to its right-hand side.
    """

    nodes: np.ndarray
    values: np.ndarray
    energy: float
    residual: float


@dataclass(eq=False)
class ElasticStep:
    """A frame of an elastic body.

    time: at its end. parts: that it was cut into, as tets would have become flat. iterations, line_search_steps,
    factorisations: the work. residual: of the forces that are left over where nothing is held, relative to the forces in the
    tets. converged: it is small enough, or as small as doubles allow. least_ratio: of a tet's volume to that at rest.
    """

    time: float
    parts: int
    iterations: int
    line_search_steps: int
    factorisations: int
    elastic_energy: float
    kinetic_energy: float
    residual: float
    converged: bool
    least_ratio: float
    seconds: float


@dataclass(eq=False)
class ElasticResult:
    """The last frame of an elastic body: V (the places) and velocities (#V x 3), von_mises (#T, of Cauchy's stress), and the
    steps that led there. converged: all of them."""

    V: np.ndarray
    velocities: np.ndarray
    von_mises: np.ndarray
    steps: List[ElasticStep]

    @property
    def converged(self) -> bool:
        return all(step.converged for step in self.steps)


@dataclass(eq=False)
class Fused:
    """The mesh that others make, to compare with.

    mesh: its `input_vertex` is -1 also where the quality pass has moved a vertex; `layers` are winding numbers.
    cut_faces: of the surface, where others cross them. inner_vertices: of the surface, inside this mesh. solid_volume: in
    which a place counts as often as it is covered.
    """

    mesh: Mesh
    cut_faces: int
    inner_vertices: int
    surface_components: int
    components: int
    solid_volume: float
    volume: float


@dataclass(eq=False)
class SkinningWeights:
    """How much each handle moves each vertex of a mesh.

    names: of the handles. weights: #V x #H. handles: as they were given. Of each handle: energy (that is least), residual (of
    the conditions of optimality), end ("exact", "gap" or "stalled": less exact than usual), held (vertices at which
    its weight is given), cut_at (of a bone: the part of its length that counts). shared: vertices that several handles
    hold.
    """

    handles: Any
    names: List[str]
    weights: np.ndarray
    energy: np.ndarray
    residual: np.ndarray
    end: List[str]
    held: np.ndarray
    cut_at: np.ndarray
    shared: int


@dataclass(eq=False)
class Skinned:
    """A mesh in a pose. flipped: how many of its tets are not positive any more; first_flipped: -1 or the first of them."""

    mesh: Mesh
    flipped: int
    first_flipped: int
