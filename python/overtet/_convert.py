"""Meshes for other programs."""
from __future__ import annotations

from typing import Any

import numpy as np

from ._types import Mesh


def to_meshio(mesh: Mesh) -> Any:
    import meshio

    cells = [("tetra", mesh.T)]
    tets = {"region": mesh.regions, "layers": mesh.layers, "gmsh:physical": mesh.regions}
    triangles: dict = {}
    if mesh.boundary is not None and len(mesh.boundary):
        cells.append(("triangle", mesh.boundary))
        triangles = {"label": mesh.labels, "boundary_face": mesh.boundary_face, "gmsh:physical": mesh.labels}
    sizes = [len(array) for _, array in cells]
    data = {}
    for key in ("region", "layers", "label", "boundary_face", "gmsh:physical"):
        blocks = [tets.get(key), triangles.get(key)][:len(cells)]
        if all(block is None for block in blocks):
            continue
        missing = -1 if key == "boundary_face" else 0
        data[key] = [np.full(size, missing, np.int32) if block is None else block
                     for block, size in zip(blocks, sizes)]
    points = dict(mesh.vertex_data)
    if mesh.input_vertex is not None:
        points["input_vertex"] = mesh.input_vertex
    names = {name: np.array([number, 3]) for number, name in mesh.region_names.items()}
    names.update({name: np.array([number, 2]) for number, name in mesh.label_names.items()})
    return meshio.Mesh(mesh.V, cells, point_data=points, cell_data=data, field_data=names)


def to_vtk(mesh: Mesh) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkCellArray, vtkUnstructuredGrid

    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(mesh.V, np.float64), deep=True))
    cells = vtkCellArray()
    offsets = np.arange(0, 4 * len(mesh.T) + 1, 4, dtype=np.int64)
    cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True),
                  numpy_to_vtkIdTypeArray(np.ascontiguousarray(mesh.T, np.int64).ravel(), deep=True))
    grid = vtkUnstructuredGrid()
    grid.SetPoints(points)
    grid.SetCells(VTK_TETRA, cells)

    def add(to: Any, name: str, values: Any) -> None:
        if values is None:
            return
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        to.AddArray(array)
    add(grid.GetCellData(), "region", mesh.regions)
    add(grid.GetCellData(), "layers", mesh.layers)
    add(grid.GetPointData(), "input_vertex", mesh.input_vertex)
    for name, values in mesh.vertex_data.items():
        add(grid.GetPointData(), name, values)
    return grid
