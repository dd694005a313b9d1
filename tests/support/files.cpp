#include "tests/support/files.h"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace overtet::test {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "overtet-test-XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("cannot make a temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

int TemporaryFolder::entries() const {
  int n = 0;
  for ([[maybe_unused]] const auto& e : fs::directory_iterator(path_)) ++n;
  return n;
}

void write_text(const std::string& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
}

std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

ShellResult shell(const std::string& command) {
  const TemporaryFolder folder;
  const int status = std::system(
      ("{ " + command + "\n} > " + folder.file("out") + " 2> " + folder.file("err") + " < /dev/null")
          .c_str());
  ShellResult r;
  r.out = read_text(folder.file("out"));
  r.err = read_text(folder.file("err"));
  if (WIFEXITED(status)) r.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) r.exit_code = -WTERMSIG(status);
  return r;
}

}  // namespace overtet::test
