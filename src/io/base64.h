// Base64, as VTK's XML files and glTF have it. Internal to src/io.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace overtet::io_detail {

// White space is passed over; padding may come in the middle, where two runs follow each other. None where
// there is another character.
std::optional<std::string> decode_base64(std::string_view text);

}  // namespace overtet::io_detail
