// One pass over bad tets that inserts vertices at them.
#pragma once

#include <cstdint>
#include <vector>

#include "overtet/run_context.h"
#include "src/improve/bad_tets.h"
#include "src/mesh/local_operations.h"

namespace overtet {

struct Insertions {
  std::int64_t count = 0;
  bool stopped = false;  // by the context, or there are `most_tets`
};

// insert(t): whether a vertex could be inserted at tet t. hopeless: of each tet, whether that was tried in
// vain and nothing has changed there since; kept up to date.
template <class Insert>
Insertions insert_at(LocalOperations& work, const std::vector<BadTet>& bad, std::vector<char>& hopeless,
                     std::int64_t most_tets, const RunContext& context, Insert&& insert) {
  const TetComplex& mesh = work.mesh();
  Insertions done;
  for (const BadTet& b : bad) {
    if (!b.still_in(mesh)) continue;
    if (context.stop() || mesh.tet_count() >= most_tets) {
      done.stopped = true;
      break;
    }
    if (!insert(b.tet)) {
      hopeless[b.tet] = 1;
      continue;
    }
    ++done.count;
    hopeless.resize(mesh.tet_capacity(), 0);
    for (const Index t : work.changed()) hopeless[t] = 0;
  }
  return done;
}

}  // namespace overtet
