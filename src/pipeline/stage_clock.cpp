#include "src/pipeline/stage_clock.h"

#include <sys/resource.h>

namespace overtet {

double cpu_seconds() {
  double sum = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage u{};
    if (getrusage(who, &u) != 0) continue;
    for (const timeval& t : {u.ru_utime, u.ru_stime})
      sum += static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  }
  return sum;
}

KernelCounts KernelCounts::now() {
  KernelCounts out;
  for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] = counted(static_cast<Count>(i));
  return out;
}

void KernelCounts::add_since(const KernelCounts& before, std::vector<Figure>& figures) const {
  static const char* const names[] = {"exact_evaluations", "tested_pairs", "contacts", "factorisations",
                                      "factor_nonzeros"};
  for (std::size_t i = 0; i < values.size(); ++i)
    if (const std::int64_t n = values[i] - before.values[i]; n > 0) figures.emplace_back(names[i], n);
}

}  // namespace overtet
