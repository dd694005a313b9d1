#include "src/improve/layers.h"

#include <atomic>

#include "kernels/parallel/counts.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/improve/tuning.h"

namespace overtet {

void mark(char& c) { std::atomic_ref(c).store(1, std::memory_order_relaxed); }

std::vector<int> star_sizes(const TetMesh& mesh) {
  std::vector<int> star(static_cast<std::size_t>(mesh.V.rows()), 0);
  count(Count::touched_tets, mesh.T.rows());
  parallel_for(mesh.T.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t)
      for (int k = 0; k < 4; ++k) std::atomic_ref(star[mesh.T(t, k)]).fetch_add(1, std::memory_order_relaxed);
  });
  return star;
}

std::vector<char> within_layers(const TetMesh& mesh, std::span<const int> star, std::vector<char> near,
                                int layers) {
  std::vector<char> chosen(static_cast<std::size_t>(mesh.T.rows()), 0);
  count(Count::touched_tets, (2 * layers - 1) * mesh.T.rows());
  for (int layer = 0; layer < layers; ++layer) {
    parallel_for(mesh.T.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t t = begin; t < end; ++t)
        for (int k = 0; k < 4; ++k)
          if (near[mesh.T(t, k)]) chosen[t] = 1;
    });
    if (layer + 1 == layers) break;
    parallel_for(mesh.T.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t t = begin; t < end; ++t)
        if (chosen[t])
          for (int k = 0; k < 4; ++k)
            if (const Index v = mesh.T(t, k); star[v] <= kLargestStar) mark(near[v]);
    });
  }
  return chosen;
}

}  // namespace overtet
