#include "src/io/file.h"
#include "src/io/vtk_data.h"

namespace overtet {

Status write_collection(const std::string& path, const std::vector<FileAtTime>& files,
                        const RunContext& context) {
  AtomicFile file;
  if (Status s = file.open(path); !s) return s;
  TextWriter out(file);
  out.text("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n");
  for (const FileAtTime& f : files)
    out.text("<DataSet timestep=\"")
        .number(f.time)
        .text("\" file=\"")
        .text(io_detail::escaped(f.file))
        .text("\"/>\n");
  out.text("</Collection>\n</VTKFile>\n");
  if (Status s = out.finish(); !s) return s;
  if (Status s = file.sync(); !s) return s;
  if (auto why = context.no_name()) return *why;
  return file.commit();
}

}  // namespace overtet
