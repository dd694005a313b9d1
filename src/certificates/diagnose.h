// Whether a surface can have a mesh at all: facts are gathered (facts.h), and each rule (rules.h) looks at
// them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "overtet/certificate.h"
#include "overtet/diagnosis.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/facts.h"
#include "src/certificates/rules.h"

namespace overtet {

struct DiagnoseOptions {
  // The whole winding range even when a certificate has been found early. `inspect` wants it, `mesh` need
  // not.
  bool full_winding_range = true;
  std::vector<rules::Rule> rules = rules::all();
  Status validate() const { return success(); }
};

struct Diagnosis : Facts {
  Verdict verdict = Verdict::bad_input;
  std::string message;                     // one sentence: why the verdict
  std::optional<Certificate> certificate;  // of the first rule that objects, where the verdict is infeasible
  std::vector<std::string> advice;         // sentences for a person
};

// Gathers the facts and goes through the rules, but for those tried on request.
// Errors: limit or interrupted only. What is wrong with the surface is in the diagnosis.
Result<Diagnosis> diagnose(const Surface& surface, const DiagnoseOptions& options, const RunContext& context);

// Goes on with the rules that are tried on request, where no other has objected; changes the verdict, the
// message and the certificate if one of them objects. Errors: limit or interrupted.
Status diagnose_further(const Surface& surface, const DiagnoseOptions& options, Diagnosis& diagnosis,
                        const RunContext& context);

// What `overtet mesh` must answer at once, if anything: bad_input (3) or infeasible (5), with the message and
// the certificate.
std::optional<Error> refuse(const Diagnosis& diagnosis);

// The vertices that a certificate names, if it does.
std::vector<Index> named_vertices(const Certificate& certificate);

}  // namespace overtet
