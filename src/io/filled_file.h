// A text file from what a function writes. For the writers of this room.
#pragma once

#include <string>

#include "overtet/run_context.h"
#include "src/io/file.h"

namespace overtet::io_detail {

// Opens the file (it has no name before commit()) and lets write(TextWriter&) fill it.
template <class Write>
Status fill(AtomicFile& file, const std::string& path, Write&& write) {
  if (Status s = file.open(path); !s) return s;
  TextWriter out(file);
  write(out);
  return out.finish();
}

// The same, and gives the file its name, if the context lets it.
template <class Write>
Status write_file(const std::string& path, const RunContext& context, Write&& write) {
  AtomicFile file;
  if (Status s = fill(file, path, write); !s) return s;
  if (Status s = file.sync(); !s) return s;
  if (auto why = context.no_name()) return *why;
  return file.commit();
}

}  // namespace overtet::io_detail
