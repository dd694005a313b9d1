// Every state of the flows as files for ParaView: a film of the surface on its way apart and back.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "overtet/result.h"
#include "overtet/types.h"
#include "src/pipeline/unit_box.h"

namespace overtet {

// One film a flow: flow.pvd with flow_0000.vtp and so on. Parts of the surface that flow by themselves, and
// further attempts, have their own: flow_2.pvd. Coordinates are those of the input's space. The list is
// written last, so that it names complete files only. Errors: io.
class FlowSeries {
 public:
  // Creates the folder if it is not there.
  static Result<FlowSeries> create(const std::string& folder, UnitBox box);

  void begin();
  // V: in the unit box. By a flow that ends in vain, too: what it leaves is what one wants to see.
  Status add(VertexMatrix V, const TriangleMatrix& F);
  Status write_list() const;

 private:
  std::string name() const;  // without ending

  std::string folder_;
  UnitBox box_;
  int flow_ = 0;
  std::size_t frames_ = 0;
};

}  // namespace overtet
