#include "overtet/certificate.h"

namespace overtet {

namespace {

struct NameOf {
  const char* operator()(const WindingCertificate&) const { return "winding"; }
  const char* operator()(const VertexCertificate&) const { return "vertex"; }
  const char* operator()(const FoldCertificate&) const { return "fold"; }
  const char* operator()(const StackCertificate&) const { return "stack"; }
  const char* operator()(const UnpairedCertificate&) const { return "unpaired"; }
  const char* operator()(const CrowdedCertificate&) const { return "crowded"; }
  const char* operator()(const LinkCertificate&) const { return "link"; }
  const char* operator()(const SharedCertificate&) const { return "shared"; }
  const char* operator()(const SeparatedCertificate&) const { return "unpaired"; }
  const char* operator()(const GluingCertificate&) const { return "gluing"; }
  const char* operator()(const CustomCertificate& c) const { return c.rule.c_str(); }
};

}  // namespace

const char* rule_name(const Certificate& certificate) { return std::visit(NameOf{}, certificate); }

}  // namespace overtet
