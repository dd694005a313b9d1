#include "src/pipeline/result_hash.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>

namespace overtet {

namespace {

class Hash {
 public:
  template <class Matrix>
  void add(const Matrix& m) {
    const std::int64_t rows = m.rows();
    add_bytes(&rows, sizeof rows);
    add_bytes(m.data(), sizeof(typename Matrix::Scalar) * static_cast<std::size_t>(m.size()));
  }
  std::string text() const {
    char digits[24];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value_));
    return digits;
  }

 private:
  void add_bytes(const void* data, std::size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) value_ = (value_ ^ p[i]) * 0x100000001b3ull;
  }

  std::uint64_t value_ = 0xcbf29ce484222325ull;
};

}  // namespace

std::string hash_of(const TetMesh& mesh) {
  Hash h;
  h.add(mesh.V);
  h.add(mesh.T);
  return h.text();
}

std::string hash_of(const Surface& surface) {
  Hash h;
  h.add(surface.V);
  h.add(surface.F);
  return h.text();
}

}  // namespace overtet
