#!/usr/bin/python3
"""Reads a tet mesh with a library that is not ours and writes it again with that library.

usage: round_trip.py LIBRARY IN OUT      LIBRARY: meshio, gmsh or vtk

Exits with 77 where the library is missing.
"""
import sys


def with_meshio(source, target):
    import meshio
    mesh = meshio.read(source)
    if target.endswith('.vtu'):
        # Other formats' sets and names are nothing to VTU.
        mesh = meshio.Mesh(mesh.points, mesh.cells, point_data=mesh.point_data, cell_data=mesh.cell_data)
        mesh.write(target, binary=True)
    elif target.endswith('.msh'):
        if 'medit:ref' in mesh.cell_data:
            refs = mesh.cell_data.pop('medit:ref')
            mesh.cell_data['gmsh:physical'] = mesh.cell_data['gmsh:geometrical'] = refs
        mesh.write(target, file_format='gmsh22', binary=False, float_fmt='.17g')
    else:
        mesh.write(target)


def with_gmsh(source, target):
    import gmsh
    gmsh.initialize()
    gmsh.option.setNumber('General.Terminal', 0)
    gmsh.option.setNumber('Mesh.SaveAll', 0)
    if target.endswith('22.msh'):
        gmsh.option.setNumber('Mesh.MshFileVersion', 2.2)
    gmsh.open(source)
    gmsh.write(target)
    gmsh.finalize()


def with_vtk(source, target):
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader, vtkUnstructuredGridWriter
    reader = vtkUnstructuredGridReader() if source.endswith('.vtk') else vtkXMLUnstructuredGridReader()
    if source.endswith('.vtk'):
        reader.ReadAllFieldsOn()
    reader.SetFileName(source)
    reader.Update()
    writer = vtkUnstructuredGridWriter() if target.endswith('.vtk') else vtkXMLUnstructuredGridWriter()
    if target.endswith('binary.vtk'):
        writer.SetFileTypeToBinary()
    if target.endswith('raw.vtu'):
        writer.SetCompressorTypeToNone()
        writer.EncodeAppendedDataOff()
    writer.SetFileName(target)
    writer.SetInputData(reader.GetOutput())
    writer.Write()


def main():
    library, source, target = sys.argv[1:]
    try:
        __import__('vtkmodules.vtkIOXML' if library == 'vtk' else library)
    except ImportError as error:
        print(error, file=sys.stderr)
        raise SystemExit(77)
    {'meshio': with_meshio, 'gmsh': with_gmsh, 'vtk': with_vtk}[library](source, target)


if __name__ == '__main__':
    main()
