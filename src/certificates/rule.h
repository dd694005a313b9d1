// What a rule is: it looks at what is known about a surface and objects to it, or not.
//
// CONTRIBUTING.md says how to add one.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "overtet/certificate.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/facts.h"

namespace overtet::rules {

// A surface of fine topology that is being diagnosed, for the rules. (Its faces have an area, but for those
// that are Rule::of_shape.) What one rule makes
// known the next ones see: nothing is computed twice.
class Case {
 public:
  Case(const Surface& surface, Facts& facts, const RunContext& context)
      : surface(surface), facts(facts), context(context) {}

  const Surface& surface;
  Facts& facts;
  const RunContext& context;

  // facts.wound, found when the first rule asks. Errors: limit or interrupted.
  Status find_wound_edges();
};

// A certificate where the rule objects, none where it does not. Errors: limit or interrupted only.
using Finding = Result<std::optional<Certificate>>;

struct Rule {
  std::function<Finding(Case&)> find;
  bool on_request = false;  // so expensive that it is tried only when asked for: see diagnose_further
  bool of_shape = false;    // needs nothing but check_shape(), and is asked of faces without area, too
};

// Numbers, or fractions where no double will do.
using Coordinates = std::array<std::variant<double, std::string>, 3>;

// A property of a certificate in a report, in the order in which they appear.
using FieldValue =
    std::variant<int, std::array<int, 3>, std::array<double, 3>, std::array<std::string, 3>, Coordinates,
                 std::vector<int>, std::vector<std::array<int, 2>>, std::vector<std::array<double, 3>>>;
using Fields = std::vector<std::pair<const char*, FieldValue>>;

// Of one vertex, as lists: "vertices", "B0", "positions". ("vertex" and "B0" by themselves are a proof, to
// who checks a witness without its rule.)
Fields vertex_fields(Index vertex, int B0, const std::array<double, 3>& position);

std::string place_text(const std::array<double, 3>& point);  // "(0.1, 2, -3.5)", six digits each

}  // namespace overtet::rules
