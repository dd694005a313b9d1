// What the library gives and takes besides matrices, as dicts of arrays and plain Python values: overtet/
// makes dataclasses of them.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "overtet/overtet.h"

namespace overtet::python {

namespace py = pybind11;

// V (#V x 3), F (#F x 3) and, where it is there, `labels`, ... of overtet.Surface. Raises what is wrong.
Surface surface_of(const py::handle& V, const py::handle& F);
SurfaceAttributes attributes_of(const py::dict& surface);
py::dict dict_of(SurfaceAttributes attributes);

TetMesh tets_of(const py::handle& V, const py::handle& T);
// The same of overtet.Mesh.
LabelledTetMesh labelled_tets_of(const py::dict& mesh);
void add(py::dict& mesh, MeshAttributes attributes);

py::dict dict_of(const TetQuality& quality);
py::dict dict_of(SurfaceDiagnosis diagnosis);
py::dict dict_of(VerifyResult result);
py::dict dict_of(Cleanup cleanup);
py::list list_of(const std::vector<Defect>& defects);
py::list list_of(const std::vector<PrepareRecord>& steps);

}  // namespace overtet::python
