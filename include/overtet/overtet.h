// All of Overtet: tet meshes of closed triangle surfaces that pass through themselves.
//
//   types.h         Surface, TetMesh
//   result.h        Result, Error: nothing is thrown for what can go wrong
//   run_context.h   limits, cancellation, threads, progress, log
//   cleanup.h       clean_up()
//   prepare.h       prepare(): cracks closed, holes filled, ...
//   meshing.h       tetrahedralize()
//   embed.h         embed(): the same surface without crossings
//   diagnosis.h     diagnose()
//   certificate.h   why there is no mesh
//   repair.h        repair_surface()
//   verification.h  verify(), tet_quality()
//   attributes.h    labels, regions, layers and what else goes with a mesh
//   curves.h        intersection_curves()
//   solve.h         solve_field(), Distances: fields on meshes
//   fused.h         fused_mesh(): what others make, to compare with
//   io.h            reading and writing
//   weights.h       skinning_weights(), skinned()
//   view.h          write_page(), write_picture(): to look at
//   report.h        what a run says about itself, as JSON
//   version.h
//
// Functions may be called from several threads at once. The library keeps no state between calls.
#pragma once

#include "overtet/attributes.h"
#include "overtet/certificate.h"
#include "overtet/cleanup.h"
#include "overtet/curves.h"
#include "overtet/diagnosis.h"
#include "overtet/elastic.h"
#include "overtet/embed.h"
#include "overtet/fused.h"
#include "overtet/io.h"
#include "overtet/meshing.h"
#include "overtet/prepare.h"
#include "overtet/repair.h"
#include "overtet/report.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/solve.h"
#include "overtet/types.h"
#include "overtet/verification.h"
#include "overtet/version.h"
#include "overtet/view.h"
#include "overtet/weights.h"
