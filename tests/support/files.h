// Files for tests: a folder that goes away, whole files as strings, other programs and what they print.
#pragma once

#include <string>

namespace overtet::test {

// A new folder, removed with everything in it at the end of the test.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  int entries() const;  // files and folders directly inside, hidden ones too

 private:
  std::string path_;
};

void write_text(const std::string& path, const std::string& text);
std::string read_text(const std::string& path);

struct ShellResult {
  int exit_code = -1;  // of the shell: 128 + signal where one ended the command
  std::string out, err;
};
// Runs a command with the shell; standard input is empty.
ShellResult shell(const std::string& command);

}  // namespace overtet::test
