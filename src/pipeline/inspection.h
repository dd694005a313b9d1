// Everything that can be said about a surface before any mesh is made, and whether a run may begin: the
// diagnosis, and what the pipeline needs on top of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "overtet/diagnosis.h"
#include "overtet/report.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/arrangement/curves.h"
#include "src/certificates/diagnose.h"
#include "src/pipeline/unit_box.h"

namespace overtet {

struct Inspection {
  Diagnosis diagnosis;
  UnitBox box;  // when there is no problem

  // Why no mesh can be made: bad_input, infeasible with its certificate, or unsolved, where nothing forbids
  // one but the coordinates are no numbers to make one of.
  std::optional<Error> problem;

  bool usable() const { return diagnosis.complete(); }
};

enum class InspectionDepth {
  verdict,    // until it is known whether a run may begin
  repair,     // the whole winding range as well: all that forbids a mesh
  everything  // the whole winding range even when a certificate has been found, and look_for_conflict
};

// Errors: limit, interrupted. What is wrong with the surface is a finding, not an error.
Result<Inspection> inspect(const Surface& surface, InspectionDepth depth, const RunContext& context);

// What the expensive rules say (diagnose_further), where nothing else forbids a mesh. If one of them objects,
// that is the inspection's verdict and problem from now on. Errors: limit, interrupted.
Status look_for_conflict(const Surface& surface, Inspection& inspection, const RunContext& context);

InputRecord input_record(const Inspection& inspection);

// What nobody needs in order to mesh, but a person wants to see.
struct CloseLook {
  std::vector<std::vector<EdgeAtHinge>> edges;  // of each hinge of the diagnosis
  Curves curves;
};

// pre: inspection.usable(). Errors: limit, interrupted.
Result<CloseLook> look_closely(const Surface& surface, const Inspection& inspection,
                               const RunContext& context);

}  // namespace overtet
