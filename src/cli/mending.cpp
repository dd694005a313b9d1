#include "src/cli/mending.h"

#include <algorithm>

namespace overtet {

std::string mend_of(const Defect& defect, bool refused) {
  if (is_mended(defect.kind))
    return refused
               ? "The clean-up mends it as soon as nothing else is in its way; overtet prepare runs it, too."
               : "The clean-up has mended it.";
  switch (defect.kind) {
    case DefectKind::hole: {
      std::int64_t edges = 3;
      for (const DefectPlace& p : defect.places) edges = std::max(edges, p.edges);
      return "overtet prepare --fill-holes " + std::to_string(edges) + " fills " +
             (defect.count == 1 ? "it" : "all of them") +
             "; if the two sides of a crack lie beside each other, --close-cracks or --weld joins them.";
    }
    case DefectKind::odd_edge:
    case DefectKind::unpaired_edge:
      return "overtet prepare takes the faces apart there; then --remove-small drops what hangs on it, "
             "--fill-holes fills what is open.";
    case DefectKind::one_sided:
      return "No step mends it: cut the surface open, or give it a second side, where it was made.";
    default:
      return "No step mends it: write the file anew where it was made.";
  }
}

std::string mend_of_flat_faces() { return "overtet prepare --collapse-needles takes them out."; }

std::string mend_of_thin_spots() {
  return "No step mends it, and it is no fault: tets there are as small as the wall is thin. Where it is not "
         "meant, make it thicker; parts that only dangle go with overtet prepare --remove-small or "
         "--largest.";
}

}  // namespace overtet
