#!/usr/bin/python3
"""Reads a tet mesh with a library that is not ours and prints what it found.

usage: read_back.py LIBRARY FILE      LIBRARY: meshio, gmsh or vtk

Prints "vertices tets", then the coordinates of every vertex as hexadecimal floats, then every tet.
"""
import sys


def with_meshio(path):
    import meshio
    m = meshio.read(path)
    tets = [t for block in m.cells if block.type == 'tetra' for t in block.data.tolist()]
    return m.points.tolist(), tets


def with_gmsh(path):
    import gmsh
    gmsh.initialize()
    gmsh.option.setNumber('General.Terminal', 0)
    gmsh.open(path)
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    kinds, _, nodes = gmsh.model.mesh.getElements(3)
    number = {int(t): i for i, t in enumerate(tags)}
    points = [[float(x) for x in xyz[3 * i:3 * i + 3]] for i in range(len(tags))]
    order = sorted(range(len(tags)), key=lambda i: tags[i])
    back = {j: i for i, j in enumerate(order)}
    tets = []
    for kind, list_ in zip(kinds, nodes):
        if kind == 4:
            list_ = [back[number[int(n)]] for n in list_]
            tets += [list_[i:i + 4] for i in range(0, len(list_), 4)]
    gmsh.finalize()
    return [points[i] for i in order], tets


def with_vtk(path):
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    r = vtkUnstructuredGridReader() if path.endswith('.vtk') else vtkXMLUnstructuredGridReader()
    r.SetFileName(path)
    r.Update()
    g = r.GetOutput()
    points = [g.GetPoint(i) for i in range(g.GetNumberOfPoints())]
    tets = []
    for i in range(g.GetNumberOfCells()):
        c = g.GetCell(i)
        if c.GetCellType() != 10:
            raise SystemExit('a cell that is not a tet')
        tets.append([c.GetPointId(k) for k in range(4)])
    return points, tets


def main():
    points, tets = {'meshio': with_meshio, 'gmsh': with_gmsh, 'vtk': with_vtk}[sys.argv[1]](sys.argv[2])
    print(len(points), len(tets))
    for p in points:
        print(*[float(x).hex() for x in p])
    for t in tets:
        print(*t)


if __name__ == '__main__':
    main()
