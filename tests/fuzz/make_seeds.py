#!/usr/bin/python3
"""Writes the seeds of the fuzzing targets: small files of every format, in the ways in which programs write them.

usage: make_seeds.py PROGRAM   (of Overtet, which writes some of the tet meshes)

The files are in the repository; this is for whoever adds a format.
"""

import base64
import gzip
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = os.path.dirname(os.path.realpath(__file__))
POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
CUBE = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def put(target, name, data):
    folder = os.path.join(HERE, "seeds", target)
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, name), "wb") as f:
        f.write(data.encode() if isinstance(data, str) else data)


def rows(lead, values):
    return "".join(lead + " ".join(map(str, v)) + "\n" for v in values)


def surfaces():
    one = [tuple(v + 1 for v in f) for f in FACES]
    put("obj", "tet", "# a tet\n" + rows("v ", POINTS) + rows("f ", one))
    put("obj", "cube", rows("v ", CUBE) + "o box\ng low high\nusemtl red\ns off\n" +
        rows("f ", [tuple(v - 8 for v in q) for q in QUADS[:3]]) + "usemtl blue\n" +
        rows("f ", [tuple(v + 1 for v in q) for q in QUADS[3:]]))
    put("obj", "textured", "mtllib x.mtl\n" + "".join(f"v {x} {y} {z} 0.5 1 0\n" for x, y, z in POINTS) +
        "vt 0 0\nvt 1 0\nvt 0 1e-3\nvt 1 1\nvn 0 0 1\n" +
        "".join("f " + " ".join(f"{v}/{v}/1" for v in f) + "\n" for f in one[:2]) +
        "f 2/2 3/-2 \\\n 4/4\nf 1//1 4//1 3//1\nl 1 2\n")
    put("off", "tet", "OFF\n4 4 6\n" + rows("", POINTS) + rows("3 ", FACES))
    put("off", "cube", "OFF # quads\n8 6 0\n" + rows("", CUBE) + rows("4 ", QUADS))
    put("off", "colours", "COFF\n4 4 0\n" + "".join(f"{x} {y} {z} 255 0 1 255\n" for x, y, z in POINTS) +
        "".join("3 %d %d %d 0.5 0 1\n" % f for f in FACES))
    put("off", "labels", "NOFF\n4 4\n" + "".join(f"{x} {y} {z} 0 0 1\n" for x, y, z in POINTS) +
        "".join("3 %d %d %d %d\n" % (f + (i // 2,)) for i, f in enumerate(FACES)))
    header = "element vertex 4\nproperty {0} x\nproperty {0} y\nproperty {0} z\nelement face 4\n"
    put("ply", "ascii", "ply\nformat ascii 1.0\ncomment a tet\n" + header.format("double") +
        "property list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "end_header\n" + rows("", POINTS) + "".join("3 %d %d %d 255 0 %d\n" % (f + (i // 2,)) for i, f in enumerate(FACES)))
    for order, name in (("<", "little"), (">", "big")):
        body = b"".join(struct.pack(order + "3f", *p) for p in POINTS)
        body += b"".join(struct.pack(order + "B3ii", 3, *f, i // 2) for i, f in enumerate(FACES))
        put("ply", name, ("ply\nformat binary_%s_endian 1.0\n" % name + header.format("float") +
            "property list uchar int vertex_index\nproperty int label\nelement edge 0\nproperty int a\n"
            "end_header\n").encode() + body)
    put("ply", "lists", "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        "property list uint8 float64 more\nproperty short s\nelement other 2\nproperty ushort n\nelement face 6\n"
        "property list uint uint vertex_indices\nend_header\n" +
        "".join("%d %d %d 2 1 2 -7\n" % p for p in CUBE) + "1\n2\n" + rows("4 ", QUADS))
    facet = "facet normal 0 0 0\nouter loop\n%sendloop\nendfacet\n"
    triangles = [[POINTS[v] for v in f] for f in FACES]
    put("stl", "ascii", "solid one\n" + "".join(facet % rows("vertex ", t) for t in triangles[:2]) + "endsolid one\nsolid two\n" +
        "".join(facet % rows("vertex ", t) for t in triangles[2:]) + "endsolid two\n")
    put("stl", "binary", b"binary".ljust(80) + struct.pack("<I", 4) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *(c for p in t for c in p), 0) for t in triangles))


def gltf():
    xyz = b"".join(struct.pack("<3f", *p) for p in POINTS)
    corners = b"".join(struct.pack("<3H", *f) for f in FACES)
    for binary in (False, True):
        j = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2]}],
            "nodes": [{"mesh": 0, "name": "outer", "children": [1], "translation": [1, 0, 0], "rotation": [0, 0, 0, 1]},
                      {"mesh": 0, "scale": [2, 2, -2]},
                      {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]}],
            "materials": [{"name": "red"}],
            "meshes": [{"name": "tet", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0, "mode": 4}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                          {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR", "byteOffset": 0}],
            "bufferViews": [{"buffer": 0, "byteLength": 48, "byteStride": 12}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
            "buffers": [{"byteLength": 72}],
        }
        if not binary:
            j["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(xyz + corners).decode()
        text = json.dumps(j, separators=(",", ":")).encode()
        if not binary:
            put("gltf", "text", text)
            continue
        text += b" " * (-len(text) % 4)
        body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", 72, b"BIN\0") + xyz + corners
        put("gltf", "binary", b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body)
    # Without a scene; colours, texture coordinates, no indices.
    data = b"".join(struct.pack("<3f", *POINTS[v]) for v in FACES[0]) + struct.pack("<6f", 0, 0, 1, 0, 0, 1) + bytes(range(12))
    put("gltf", "plain", json.dumps({
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 2}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5121, "count": 3, "type": "VEC4", "normalized": True}],
        "bufferViews": [{"buffer": 0}, {"buffer": 0, "byteOffset": 36}, {"buffer": 0, "byteOffset": 60}],
        "buffers": [{"byteLength": 72, "uri": "data:;base64," + base64.b64encode(data).decode()}]}))
    put("gltf", "file", '{"asset":{},"extensionsRequired":["KHR_mesh_quantization"],"meshes":[{"primitives":[{"attributes":'
        '{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5122,"count":3,"type":"VEC3"}],"bufferViews":'
        '[{"buffer":0}],"buffers":[{"uri":"x.bin"}]}')


MEDIT = ("MeshVersionFormatted 2\nDimension 3\n# a tet with its faces\nVertices\n4\n" + rows("", [p + (0,) for p in POINTS]) +
         "Edges\n1\n1 2 7\nTriangles\n4\n" + rows("", [tuple(v + 1 for v in f) + (i // 2 + 1,) for i, f in enumerate(FACES)]) +
         "Tetrahedra\n1\n1 2 3 4 5\nEnd\n")


def meshes():
    put("medit", "tet", MEDIT)
    put("medit", "second", "MeshVersionFormatted 1 Dimension 3\nVertices 10\n" +
        rows("", [(i, i * i % 7, i % 3, 0) for i in range(10)]) + "TetrahedraP2\n1\n1 2 3 4 5 6 7 8 9 10 3\nTrianglesP2\n1\n1 2 3 5 6 7 1\n"
        "Quadrilaterals\n1\n1 2 3 4 0\nCorners\n1\n1\nEnd\n")
    points = "".join("%d %d %d %d\n" % ((i + 1,) + p) for i, p in enumerate(POINTS))
    put("gmsh", "old", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 3 \"wall\"\n3 7 \"inside it\"\n$EndPhysicalNames\n"
        "$Nodes\n4\n" + points + "$EndNodes\n$Elements\n6\n" +
        "".join("%d 2 2 3 1 %d %d %d\n" % ((i + 1,) + tuple(v + 1 for v in f)) for i, f in enumerate(FACES)) +
        "5 4 2 7 1 1 2 3 4\n6 15 2 0 1 1\n$EndElements\n")
    put("gmsh", "new", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Comments\nwords\n$EndComments\n$PhysicalNames\n1\n2 3 \"wall\"\n$EndPhysicalNames\n"
        "$Entities\n1 0 1 1\n1 0 0 0 0\n1 0 0 0 1 1 1 1 3 0\n1 0 0 0 1 1 1 0 1 1\n$EndEntities\n$Nodes\n2 4 10 40\n2 1 0 2\n10\n20\n0 0 0\n1 0 0\n"
        "3 1 1 2\n30\n40\n0 1 0 0 0 0\n0 0 1 0 0 0\n$EndNodes\n$Elements\n2 3 1 9\n2 1 2 2\n1 10 30 20\n2 10 20 40\n3 1 4 1\n9 10 20 30 40\n$EndElements\n"
        "$NodeData\n1\n\"input_vertex\"\n1\n0\n3\n0\n1\n2\n10 5\n20 6\n$EndNodeData\n$ElementData\n1\n\"layers\"\n1\n0.0\n3\n0\n1\n1\n9 2\n$EndElementData\n")
    put("gmsh", "second", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n" + rows("", [(i, i, i % 3, i % 4) for i in range(1, 11)]) +
        "$EndNodes\n$Elements\n2\n1 11 2 0 0 1 2 3 4 5 6 7 8 9 10\n2 16 3 1 2 3 1 2 3 4 5 6 7 8\n$EndElements\n")
    put("abaqus", "tet", "*HEADING\nx\n*NODE, NSET=ALL\n" + "".join("%d, %d, %d, %d\n" % ((i + 1,) + p) for i, p in enumerate(POINTS)) +
        "** region 1 solid\n*ELEMENT, TYPE=C3D4, ELSET=REGION_1\n1, 1, 2, 3, 4\n** label 2 wall\n*SURFACE, TYPE=ELEMENT, NAME=LABEL_2_WALL\n1, S1\n"
        "*SURFACE, TYPE=ELEMENT, NAME=other\n1, S2\n*STEP\n1\n*END STEP\n")
    put("abaqus", "second", "** exact: 2, 0.12345678901234567, -1e-300, 3\n*Node\n" + "".join("%d, %d, %d\n" % (i, i, i % 3) for i in range(1, 11)) +
        "*Element, type=C3D10, elset=steel\n7, 1, 2, 3, 4, 5,\n6, 7, 8, 9, 10\n*Surface, name=BOUNDARY\n7, S4\nset, S1\n")
    put("tetgen", "tet", "4 3 0 1\n" + "".join("%d %d %d %d 1\n" % ((i,) + p) for i, p in enumerate(POINTS)) + "%\n1 4 1\n0 0 1 2 3 -7\n%\n4 1\n" +
        "".join("%d %d %d %d %d\n" % ((i,) + f + (i,)) for i, f in enumerate(FACES)))
    put("tetgen", "second", "# counted from 1\n10 3 0 0\n" + rows("", [(i, i, i % 3, i % 4) for i in range(1, 11)]) +
        "%\n1 10 0\n1 1 2 3 4 5 6 7 8 9 10\n%\n1 0\n1 1 3 2\n")


def packed(values, code):
    return struct.pack("<%d%s" % (len(values), code), *values)


def vtk():
    xyz = [c for p in POINTS for c in p]
    arrays = {"points": ("Float64", packed(xyz, "d")), "connectivity": ("Int32", packed([0, 1, 2, 3, 0, 2, 1], "i")),
              "offsets": ("Int64", packed([4, 7], "q")), "types": ("UInt8", bytes([10, 5])), "label": ("Int32", packed([3, 4], "i"))}

    def document(array, tail="", attributes=""):
        return ('<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"%s>\n<UnstructuredGrid>\n'
                '<Piece NumberOfPoints="4" NumberOfCells="2">\n<CellData>%s</CellData>\n<Points>%s</Points>\n<Cells>%s%s%s</Cells>\n</Piece>\n'
                '</UnstructuredGrid>\n' % (attributes, array("label"), array("points"), array("connectivity"), array("offsets"), array("types"))).encode() + tail + b"</VTKFile>\n"

    def tag(name, rest):
        width = ' NumberOfComponents="3"' if name == "points" else ""
        return '<DataArray type="%s" Name="%s"%s %s</DataArray>\n' % (arrays[name][0], name, width, rest)

    codes = {"Float64": "d", "Int32": "i", "Int64": "q", "UInt8": "B"}
    text = {n: " ".join(str(x) for x in struct.unpack("<%d%s" % (len(b) // struct.calcsize(codes[t]), codes[t]), b)) for n, (t, b) in arrays.items()}
    put("vtk_xml", "ascii", document(lambda n: tag(n, 'format="ascii">' + text[n]), b""))
    put("vtk_xml", "base64", document(lambda n: tag(n, 'format="binary">' + base64.b64encode(struct.pack("<I", len(arrays[n][1])) + arrays[n][1]).decode()), b""))

    def compressed(name):
        data = arrays[name][1]
        z = zlib.compress(data)
        return base64.b64encode(struct.pack("<4I", 1, len(data), 0, len(z))).decode() + base64.b64encode(z).decode()
    put("vtk_xml", "zlib", document(lambda n: tag(n, 'format="binary">' + compressed(n)), b"", ' compressor="vtkZLibDataCompressor"'))
    for squeeze in (False, True):
        blob, offset = b"", {}
        for n, (t, b) in arrays.items():
            offset[n] = len(blob)
            if squeeze:  # two blocks
                half = (len(b) + 1) // 2
                z = [zlib.compress(b[:half]), zlib.compress(b[half:])]
                blob += struct.pack("<5Q", 2, half, len(b) - half, len(z[0]), len(z[1])) + z[0] + z[1]
            else:
                blob += struct.pack("<Q", len(b)) + b
        put("vtk_xml", "raw_zlib" if squeeze else "raw",
            document(lambda n: tag(n, 'format="appended" offset="%d">' % offset[n]), b'<AppendedData encoding="raw">\n_' + blob + b"\n</AppendedData>\n",
                     ' header_type="UInt64"' + (' compressor="vtkZLibDataCompressor"' if squeeze else "")))
    put("vtk_xml", "poly", '<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData><Piece NumberOfPoints="4" NumberOfVerts="1" '
        'NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="2"><PointData><DataArray type="Float32" Name="t">1 2 3 4</DataArray></PointData>'
        '<CellData><DataArray type="UInt8" Name="c" NumberOfComponents="2" format="ascii">1 2 3 4 5 6</DataArray></CellData>'
        '<Points><DataArray type="Float32" NumberOfComponents="3">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Verts><DataArray type="Int32" '
        'Name="connectivity">0</DataArray></Verts><Polys><DataArray type="Int32" Name="connectivity">0 2 1 0 1 3 2</DataArray><DataArray type="Int32" '
        'Name="offsets">3 7</DataArray></Polys></Piece></PolyData></VTKFile>')
    head = "# vtk DataFile Version %s\nx\n%s\nDATASET %s\n"
    put("vtk", "poly", head % ("3.0", "ASCII", "POLYDATA") + "POINTS 4 float\n" + rows("", POINTS) + "VERTICES 1 2\n1 0\nPOLYGONS 4 16\n" + rows("3 ", FACES) +
        "CELL_DATA 5\nSCALARS label int 1\nLOOKUP_TABLE default\n0 1 1 2 2\nPOINT_DATA 4\nVECTORS v double\n" + rows("", POINTS) +
        "COLOR_SCALARS c 2\n0 1 0 1 0 1 0 1\nTEXTURE_COORDINATES uv 2 float\n0 0 1 0 0 1 1 1\nFIELD f 1\na 1 4 double\n1 2 nan 4\n")
    put("vtk", "grid", head % ("4.2", "ASCII", "UNSTRUCTURED_GRID") + "POINTS 4 double\n" + rows("", POINTS) + "CELLS 2 9\n4 0 1 2 3\n3 0 2 1\nCELL_TYPES 2\n10\n5\n"
        "CELL_DATA 2\nFIELD FieldData 1\nregion 1 2 int\n7 8\n")
    put("vtk", "new", head % ("5.1", "ASCII", "UNSTRUCTURED_GRID") + "FIELD FieldData 1\ntime 1 1 double\n0\nPOINTS 4 double\n" + rows("", POINTS) +
        "METADATA\nINFORMATION 0\n\nCELLS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\nCELL_TYPES 1\n10\n")
    put("vtk", "binary", (head % ("3.0", "BINARY", "UNSTRUCTURED_GRID") + "POINTS 4 float\n").encode() + struct.pack(">12f", *xyz) + b"\nCELLS 1 5\n" +
        struct.pack(">5i", 4, 0, 1, 2, 3) + b"\nCELL_TYPES 1\n" + struct.pack(">i", 10) + b"\nCELL_DATA 1\nSCALARS s short\nLOOKUP_TABLE default\n" + struct.pack(">h", -2))


def written(program):
    """A tet mesh with labels, as Overtet itself writes it in each format."""
    folder = tempfile.mkdtemp()
    try:
        source = os.path.join(folder, "in.mesh")
        with open(source, "w") as f:
            f.write(MEDIT)
        for target, form, extension in (("gmsh", "msh22", "msh"), ("gmsh", "msh41", "msh"), ("vtk_xml", "vtu", "vtu"),
                                        ("vtk", "vtk", "vtk"), ("abaqus", "abaqus", "inp")):
            out = os.path.join(folder, "out." + extension)
            subprocess.run([program, "convert", source, out, "--format", form, "-q"], check=True)
            with open(out, "rb") as f:
                put(target, "ours_" + form, f.read())
        with open(os.path.join(folder, "out.vtu"), "rb") as f:
            vtu = f.read()
    finally:
        shutil.rmtree(folder)
    with open(os.path.join(HERE, "seeds", "ply", "little"), "rb") as f:
        ply = f.read()
    stages = json.dumps({"version": "@", "input_hash": "0123456789abcdef", "stages": ["embedded", "mapped"], "placed": 1}, indent=2)
    put("resume", "both", (stages + "\n%\n").encode() + ply + b"%\n" + vtu)
    put("resume", "other", stages.replace("@", "9.9"))
    put("resume", "empty", '{"version":"@","input_hash":"0123456789abcdef","stages":[]}\n%\n%\n')


def others():
    put("sizes", "mixed", "# one a vertex\n1 0 2.5\n1e-3 +7\n\n0.0000001\n")
    put("sizes", "wrong", "1 -2\n")
    put("handles", "json", '{"handles":[{"name":"a","head":[0,0,0],"tail":[1,0,0]},{"name":"b","tail":3,"parent":"a"},'
        '{"name":"c","vertex":1},{"name":"d","position":[0,1,2],"layer":1}],"cage_edges":[["c","d"]]}\n%\n'
        '{"a":{"axis":[0,0,1],"degrees":9},"c":{"matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0]]}}\n%\n'
        'vertex,a,b,c,d\n0,.1,.2,.3,.4\n')
    put("handles", "tgf", '1 0 0 0\n2 1 0 0\n3 2 0 .5\n4 1 1 1\n#\n1 2 1 0 0\n2 3 1\n%\n{"bone_1":{"quaternion":[0,0,1,1]}}\n%\n'
        'vertex,point_4,bone_1,"bone_2"\n0,0,1,0\n')
    put("gzip", "text", gzip.compress(b"OFF\n4 4 6\n" * 9, mtime=0))
    put("gzip", "members", gzip.compress(b"abc", mtime=0) + gzip.compress(bytes(range(256)), 1, mtime=0) + b"\0\0\0")
    put("gzip", "zlib", b"\x14" + zlib.compress(b"x" * 20))
    put("gzip", "plain", b"nothing compressed")
    cube = bytes([7]) + bytes(c for p in CUBE for c in p)
    triangles = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
    put("cleanup", "cube", cube + bytes(v for t in triangles for v in t))
    put("cleanup", "open", cube + bytes(v for t in triangles[:-1] for v in t))
    put("cleanup", "turned", cube + bytes(v for i, (a, b, c) in enumerate(triangles) for v in ((a, b, c) if i % 5 else (a, c, b))))
    put("cleanup", "two", bytes([7]) + bytes(c for shift in (0, 2) for p in POINTS for c in (p[0] + shift, p[1], p[2])) +
        bytes(v + s for s in (0, 4) for f in FACES for v in f) + bytes([0, 0, 1, 3, 2, 1]))
    put("cleanup", "soup", bytes([11]) + bytes(c for f in FACES for v in f for c in POINTS[v]) + bytes(range(12)))
    put("cleanup", "inward", bytes([3]) + bytes(c for p in POINTS for c in p) + bytes(v for a, b, c in FACES for v in (a, c, b)))


def batches():
    entry = {"journal": 1, "name": "a/b", "sha256": "00ff", "options": ["--improve", "20"], "version": "0.1.0", "input": "/x/b.obj", "input_bytes": 12,
             "status": "exact", "exit_code": 0, "message": "", "outputs": [{"file": "a/b.mesh", "bytes": 9}], "seconds": 1.5, "cpu_seconds": 2.25,
             "peak_rss_bytes": 1048576, "threads": 2, "tries": 1, "time_limit": 0, "memory_limit_bytes": 0, "vertices": 4, "faces": 4, "tets": 1,
             "dihedral_min": 54.7, "dihedral_p01": 54.7, "result_hash": "0123", "host": "h", "shard": "", "ended": "2026-11-30T18:00:00Z"}
    other = dict(entry, name="c", status="crashed", exit_code=None, message="a signal", outputs=[], vertices=None, faces=None, tets=None,
                 dihedral_min=None, dihedral_p01=None, shard="2/20", seconds=1e-3)
    lines = [json.dumps(e, separators=(",", ":")) for e in (entry, other, dict(other, status="infeasible", exit_code=5, ended="2026-11-30T19:00:00Z"))]
    put("journal", "three", "".join(line + "\n" for line in lines))
    put("journal", "cut", lines[0] + "\n" + lines[1][:100])
    put("manifest", "plain", "# models\na.obj\n\nfolder/b.off\n../c.ply.gz\n/abs/d.stl\na.off\n")
    put("manifest", "json", '{"input": "scans/hand 3.obj", "output": "hands/3", "options": ["--improve", "20"]}\n{"input": "a\\nb.obj"}\nx.obj\nx.obj\n')
    put("manifest", "wrong", '{"input": 3}\n')


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    surfaces()
    gltf()
    meshes()
    vtk()
    written(sys.argv[1])
    others()
    batches()
