#include "src/view/page_parts.h"

// The assembler takes the files as they are. A compiler would take a minute for half a megabyte of numbers.
#define OVERTET_INCLUDE_FILE(name, file)                                     \
  asm(".pushsection .rodata\n" #name "_begin:\n.incbin \"" file "\"\n" #name \
      "_end:\n.byte 0\n.popsection\n");                                      \
  extern "C" const char name##_begin[], name##_end[]

OVERTET_INCLUDE_FILE(overtet_page_script, OVERTET_PAGE "/bundle.js");
OVERTET_INCLUDE_FILE(overtet_page_style, OVERTET_PAGE "/page.css");
OVERTET_INCLUDE_FILE(overtet_page_body, OVERTET_PAGE "/index.html");

namespace overtet {

namespace {

std::string_view between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

std::string_view page_script() { return between(overtet_page_script_begin, overtet_page_script_end); }
std::string_view page_style() { return between(overtet_page_style_begin, overtet_page_style_end); }
std::string_view page_body() { return between(overtet_page_body_begin, overtet_page_body_end); }

}  // namespace overtet
