// Base64, as VTK's XML files, glTF and pages have it. For src/io and src/view.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace overtet::io_detail {

// White space is passed over; padding may come in the middle, where two runs follow each other. None where
// there is another character.
std::optional<std::string> decode_base64(std::string_view text);

// With padding. Texts of pieces join to that of the whole if all pieces but the last are multiples of three
// bytes.
std::string encode_base64(std::string_view bytes);

}  // namespace overtet::io_detail
