// The page's own files, as they lie in page/. Internal to src/view.
#pragma once

#include <string_view>

namespace overtet {

std::string_view page_script();  // page/bundle.js
std::string_view page_style();   // page/page.css
std::string_view page_body();    // page/index.html

}  // namespace overtet
