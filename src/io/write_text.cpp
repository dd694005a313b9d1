#include "overtet/io.h"
#include "src/io/file.h"

namespace overtet {

Status write_text(const std::string& path, std::string_view text) {
  AtomicFile file;
  if (Status s = file.open(path); !s) return s;
  if (Status s = file.write(text); !s) return s;
  return file.commit();
}

}  // namespace overtet
