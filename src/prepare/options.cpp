#include "overtet/prepare.h"

namespace overtet {

const char* name_of(PrepareStep step) {
  switch (step) {
    case PrepareStep::weld:
      return "weld";
    case PrepareStep::close_cracks:
      return "close-cracks";
    case PrepareStep::remove_small:
      return "remove-small";
    case PrepareStep::largest:
      return "largest";
    case PrepareStep::fill_holes:
      return "fill-holes";
    case PrepareStep::collapse_needles:
      return "collapse-needles";
  }
  return "";
}

PrepareOptions PrepareOptions::all() {
  PrepareOptions o;
  o.close_cracks = true;
  o.remove_small = 10;
  o.fill_holes = 100;
  o.collapse_needles = true;
  return o;
}

Status PrepareOptions::validate() const {
  const auto usage = [](const char* message) { return Error{ErrorCode::usage, message}; };
  if (!any()) return usage("No step is asked for, so there is nothing to prepare.");
  if (!(weld >= 0 && weld <= 0.1))
    return usage("The distance to weld within must lie between 0 and 10 % of the diagonal.");
  if (!(tolerance > 0 && tolerance <= 0.1))
    return usage("The tolerance must lie between 0 and 10 % of the diagonal, and not be 0.");
  if (remove_small < 0) return usage("The number of faces of a component cannot be negative.");
  if (fill_holes != 0 && (fill_holes < 3 || fill_holes > 5000))
    return usage("Holes to be filled must have 3 to 5000 edges.");
  if (!(needle_degrees > 0 && needle_degrees <= 30))
    return usage("The angle of a needle must lie between 0 and 30 degrees.");
  if (most_places < 1 || most_places > 1000000)
    return usage("The number of places to list must lie between 1 and 1000000.");
  return success();
}

}  // namespace overtet
