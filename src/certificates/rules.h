// All rules, each in a file of its own (NAME_rule.cpp): how it is called, how it finds its certificate, the
// sentence and the properties of the report that it makes of it. What each proves is said at its certificate,
// in overtet/certificate.h.
#pragma once

#include <string>
#include <vector>

#include "overtet/certificate.h"
#include "src/certificates/rule.h"

namespace overtet::rules {

inline const char* name(const AreaCertificate&) { return "area"; }
inline bool forbids_branch_lines(const AreaCertificate&) { return true; }
Finding find_area(Case& c);
std::string explain(const AreaCertificate& c);
Fields fields(const AreaCertificate& c);

inline const char* name(const WindingCertificate&) { return "winding"; }
inline bool forbids_branch_lines(const WindingCertificate&) { return true; }
Finding find_winding(Case& c);
std::string explain(const WindingCertificate& c);
Fields fields(const WindingCertificate& c);

inline const char* name(const VertexCertificate&) { return "vertex"; }
inline bool forbids_branch_lines(const VertexCertificate&) { return true; }
Finding find_vertex(Case& c);
std::string explain(const VertexCertificate& c);
Fields fields(const VertexCertificate& c);

inline const char* name(const FoldCertificate&) { return "fold"; }
inline bool forbids_branch_lines(const FoldCertificate&) { return true; }
Finding find_fold(Case& c);
std::string explain(const FoldCertificate& c);
Fields fields(const FoldCertificate& c);

inline const char* name(const StackCertificate&) { return "stack"; }
inline bool forbids_branch_lines(const StackCertificate&) { return true; }
Finding find_stack(Case& c);
std::string explain(const StackCertificate& c);
Fields fields(const StackCertificate& c);

inline const char* name(const UnpairedCertificate&) { return "unpaired"; }
inline bool forbids_branch_lines(const UnpairedCertificate&) { return false; }
Finding find_unpaired(Case& c);
std::string explain(const UnpairedCertificate& c);
Fields fields(const UnpairedCertificate& c);

inline const char* name(const CrowdedCertificate&) { return "crowded"; }
inline bool forbids_branch_lines(const CrowdedCertificate&) { return false; }
Finding find_crowded(Case& c);
std::string explain(const CrowdedCertificate& c);
Fields fields(const CrowdedCertificate& c);

inline const char* name(const LinkCertificate&) { return "link"; }
inline bool forbids_branch_lines(const LinkCertificate&) { return false; }
Finding find_link(Case& c);
std::string explain(const LinkCertificate& c);
Fields fields(const LinkCertificate& c);

inline const char* name(const SharedCertificate&) { return "shared"; }
inline bool forbids_branch_lines(const SharedCertificate&) { return false; }
Finding find_shared(Case& c);
std::string explain(const SharedCertificate& c);
Fields fields(const SharedCertificate& c);

inline const char* name(const SeparatedCertificate&) { return "unpaired"; }
inline bool forbids_branch_lines(const SeparatedCertificate&) { return false; }
Finding find_separated(Case& c);
std::string explain(const SeparatedCertificate& c);
Fields fields(const SeparatedCertificate& c);

inline const char* name(const GluingCertificate&) { return "gluing"; }
inline bool forbids_branch_lines(const GluingCertificate&) { return false; }
Finding find_gluing(Case& c);
std::string explain(const GluingCertificate& c);
Fields fields(const GluingCertificate& c);

// What a rule outside of the library found speaks for itself.
inline const char* name(const CustomCertificate& c) { return c.rule.c_str(); }
inline bool forbids_branch_lines(const CustomCertificate&) { return true; }
inline std::string explain(const CustomCertificate& c) { return c.explanation; }
inline Fields fields(const CustomCertificate& c) {
  return {{"vertices", c.vertices}, {"positions", c.positions}};
}

// In the order in which they are tried; the first that objects decides. Cheap ones come first, and those that
// are easy to check by hand.
inline std::vector<Rule> all() {
  return {{find_area, false, true}, {find_winding}, {find_vertex}, {find_fold},   {find_stack},
          {find_unpaired},          {find_crowded}, {find_link},   {find_shared}, {find_separated},
          {find_gluing, true}};
}

}  // namespace overtet::rules
