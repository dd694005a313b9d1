#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "overtet/verification.h"
#include "overtet/version.h"
#include "src/pipeline/stage_files.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/targets.h"

namespace overtet::fuzz {

namespace {

// A folder of saved stages, used again and again. (TMPDIR in memory makes it fast.)
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("overtet-fuzz-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  void put(const char* name, std::string_view bytes) const {
    std::ofstream file(path_ / name, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

// The input that the stages are of: seeds/resume has its states.
Surface input() {
  Surface s;
  s.V.resize(4, 3);
  s.V << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  s.F.resize(4, 3);
  s.F << 0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2;
  return s;
}

template <class T>
void judge(const Result<T>& loaded, const Surface& surface) {
  if (!loaded) return check_error(loaded.error());
  if constexpr (std::is_same_v<T, Draft>) {
    const Draft& d = loaded.value();
    require(d.placed >= 0 && d.placed <= std::max<Eigen::Index>(d.mesh.V.rows() - surface.V.rows(), 0),
            "more vertices are placed than there are");
    static_cast<void>(verify(surface, d.mesh));
  } else {
    static_cast<void>(verify(surface, loaded.value()));
  }
}

}  // namespace

void resume(std::string_view bytes) {
  static const Folder folder;
  static const Surface surface = input();
  const std::vector<std::string_view> files = parts_of(bytes, 3);
  std::string index(files[0]);  // "@": this version
  if (const std::size_t at = index.find("\"@\""); at != std::string::npos)
    index.replace(at + 1, 1, version());
  folder.put("stages.json", index);
  const MemoryUse memory;
  const Result<StageFiles> stages =
      StageFiles::open(folder.path(), "0123456789abcdef", UnitBox{{-1, -1, -1}});
  memory.check(bytes.size());
  if (!stages) return check_error(stages.error());
  if (stages.value().has("embedded")) {
    folder.put("embedded.ply", files[1]);
    const Result<Surface> embedded = stages.value().load_surface("embedded");
    if (!embedded) check_error(embedded.error());
  }
  folder.put("mapped.vtu", files[2]);
  if (stages.value().has("mapped"))
    judge(stages.value().load_draft("mapped", 4), surface);
  else
    judge(stages.value().load_mesh("mapped", 4), surface);
}

}  // namespace overtet::fuzz
