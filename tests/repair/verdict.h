#pragma once

#include "src/certificates/diagnose.h"

namespace overtet::test {

inline Verdict verdict_of(const Surface& s) {
  const auto d = diagnose(s, {}, {});
  return d.ok() ? d.value().verdict : Verdict::bad_input;
}

}  // namespace overtet::test
