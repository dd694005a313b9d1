#include "kernels/sparse/cholesky.h"

#include <dlfcn.h>
#include <suitesparse/cholmod.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "kernels/parallel/counts.h"

namespace overtet {

namespace {

// CHOLMOD's functions, loaded when the first factor is asked for: with it come a BLAS, LAPACK, METIS and the
// run-time libraries of Fortran and OpenMP, a third of what a program takes to start, and most runs factor
// nothing. Global, because the names of those libraries are looked up below.
struct Cholmod {
  Cholmod() {
    // By the name that the loader knows this ABI by.
    const std::string name = "libcholmod.so." + std::to_string(CHOLMOD_MAIN_VERSION);
    void* library = dlopen(name.c_str(), RTLD_NOW | RTLD_GLOBAL);
    // Where the loader does not look: as it was found when this was built.
    if (!library) library = dlopen(OVERTET_CHOLMOD_FILE, RTLD_NOW | RTLD_GLOBAL);
    if (!library) {
      // The loader says "cannot allocate memory" or "failed to map segment".
      const char* const why = dlerror();
      const std::string_view reason = why ? why : "";
      if (reason.find("memory") != reason.npos || reason.find("map segment") != reason.npos)
        throw std::bad_alloc();
      throw std::runtime_error("cannot load " + name + " (of SuiteSparse)");
    }
    find(library, "cholmod_start", start);
    find(library, "cholmod_finish", finish);
    find(library, "cholmod_analyze", analyze);
    find(library, "cholmod_factorize", factorize);
    find(library, "cholmod_solve2", solve2);
    find(library, "cholmod_free_factor", free_factor);
    find(library, "cholmod_free_dense", free_dense);
  }

  template <class Function>
  static void find(void* library, const char* name, Function*& function) {
    function = reinterpret_cast<Function*>(dlsym(library, name));
    if (!function) throw std::runtime_error(std::string("CHOLMOD has no ") + name);
  }

  decltype(cholmod_start)* start;
  decltype(cholmod_finish)* finish;
  decltype(cholmod_analyze)* analyze;
  decltype(cholmod_factorize)* factorize;
  decltype(cholmod_solve2)* solve2;
  decltype(cholmod_free_factor)* free_factor;
  decltype(cholmod_free_dense)* free_dense;
};

const Cholmod& cholmod() {
  static const Cholmod loaded;
  return loaded;
}

// A threaded BLAS is told once to use one thread. The reference BLAS has no such function.
void pin_blas_to_one_thread() {
  static std::once_flag once;
  std::call_once(once, [] {
    for (const char* name : {"openblas_set_num_threads", "bli_thread_set_num_threads", "MKL_Set_Num_Threads"})
      if (void* f = dlsym(RTLD_DEFAULT, name)) reinterpret_cast<void (*)(int)>(f)(1);
  });
}

// OpenBLAS that was built for one thread (Debian's libopenblas0-serial) hands the same buffer to two threads
// that call it at the same time: factors come out wrong. Then they wait for each other. Simplicial factors do
// without a BLAS.
std::unique_lock<std::mutex> blas_turn(const cholmod_factor* factor) {
  static std::mutex mutex;
  static const bool needed = [] {
    void* const f = dlsym(RTLD_DEFAULT, "openblas_get_parallel");
    return f && reinterpret_cast<int (*)()>(f)() == 0;
  }();
  return needed && factor->is_super ? std::unique_lock(mutex) : std::unique_lock<std::mutex>();
}

// CHOLMOD's supernodal loops ask for four OpenMP threads whatever the caller says: in this thread they get
// one. (Measured: otherwise a sixth of a volume patch's step is spent waiting for and waking threads.)
void pin_openmp_to_one_thread() {
  thread_local const bool done = [] {
    if (void* f = dlsym(RTLD_DEFAULT, "omp_set_max_active_levels")) reinterpret_cast<void (*)(int)>(f)(0);
    return true;
  }();
  static_cast<void>(done);
}

// A view of Eigen's arrays; CHOLMOD reads them only.
cholmod_sparse view(const SymmetricMatrix& A) {
  cholmod_sparse s{};
  s.nrow = static_cast<std::size_t>(A.rows());
  s.ncol = static_cast<std::size_t>(A.cols());
  s.nzmax = static_cast<std::size_t>(A.nonZeros());
  s.p = const_cast<int*>(A.outerIndexPtr());
  s.i = const_cast<int*>(A.innerIndexPtr());
  s.x = const_cast<double*>(A.valuePtr());
  s.stype = -1;
  s.itype = CHOLMOD_INT;
  s.xtype = CHOLMOD_REAL;
  s.dtype = CHOLMOD_DOUBLE;
  s.sorted = 1;
  s.packed = 1;
  return s;
}

}  // namespace

struct SparseCholesky::Impl {
  explicit Impl(const CholeskyOptions& options) {
    cholmod().start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.nmethods = 1;
    using Ordering = CholeskyOptions::Ordering;
    using Method = CholeskyOptions::Method;
    automatic = options.ordering == Ordering::automatic;
    common.method[0].ordering = options.ordering == Ordering::metis     ? CHOLMOD_METIS
                                : options.ordering == Ordering::natural ? CHOLMOD_NATURAL
                                                                        : CHOLMOD_AMD;
    common.postorder = 1;
    common.supernodal = options.method == Method::simplicial   ? CHOLMOD_SIMPLICIAL
                        : options.method == Method::supernodal ? CHOLMOD_SUPERNODAL
                                                               : CHOLMOD_AUTO;
    // LL' rather than LDL': a matrix that is not positive definite is found, not factored anyway.
    common.final_ll = 1;
    common.quick_return_if_not_posdef = 1;
  }
  ~Impl() {
    cholmod().free_factor(&L, &common);
    cholmod().free_dense(&X, &common);
    cholmod().free_dense(&Y, &common);
    cholmod().free_dense(&E, &common);
    cholmod().finish(&common);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  cholmod_common common{};
  cholmod_factor* L = nullptr;
  cholmod_dense* X = nullptr;  // kept from solve to solve
  cholmod_dense* Y = nullptr;
  cholmod_dense* E = nullptr;
  std::vector<double> columns;
  Eigen::Index rows = -1, entries = -1;
  bool factored = false;
  bool automatic = false;
};

SparseCholesky::SparseCholesky(const CholeskyOptions& options) {
  cholmod();
  pin_blas_to_one_thread();
  impl_ = std::make_unique<Impl>(options);
}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

bool SparseCholesky::analyze(const SymmetricMatrix& A) {
  Impl& m = *impl_;
  cholmod().free_factor(&m.L, &m.common);
  m.factored = false;
  m.rows = -1;
  if (A.rows() != A.cols() || !A.isCompressed()) return false;
  if (A.rows() > 0) {
    if (m.automatic) m.common.method[0].ordering = A.rows() < kMetisRows ? CHOLMOD_AMD : CHOLMOD_METIS;
    cholmod_sparse s = view(A);
    m.L = cholmod().analyze(&s, &m.common);
    if (!m.L) return false;
  }
  m.rows = A.rows();
  m.entries = A.nonZeros();
  return true;
}

bool SparseCholesky::factor(const SymmetricMatrix& A) {
  Impl& m = *impl_;
  m.factored = false;
  if (m.rows < 0 || A.rows() != m.rows || A.nonZeros() != m.entries || !A.isCompressed()) return false;
  if (m.rows > 0) {
    // NaN passes CHOLMOD's positivity test (d <= 0 is false for it).
    const double* x = A.valuePtr();
    for (Eigen::Index i = 0; i < m.entries; ++i)
      if (!std::isfinite(x[i])) return false;
    pin_openmp_to_one_thread();
    cholmod_sparse s = view(A);
    const auto turn = blas_turn(m.L);
    if (!cholmod().factorize(&s, m.L, &m.common) || m.common.status != CHOLMOD_OK) return false;
    if (m.L->minor < static_cast<std::size_t>(m.rows)) return false;
    count(Count::factorisations);
    count(Count::factor_nonzeros, static_cast<std::int64_t>(m.common.lnz));
  }
  m.factored = true;
  return true;
}

// columns: of the right-hand side, as many as are solved for.
bool SparseCholesky::solve_columns(Eigen::Index columns) const {
  Impl& m = *impl_;
  pin_openmp_to_one_thread();
  cholmod_dense b{};
  b.nrow = static_cast<std::size_t>(m.rows);
  b.ncol = static_cast<std::size_t>(columns);
  b.nzmax = b.nrow * b.ncol;
  b.d = b.nrow;
  b.x = m.columns.data();
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  const auto turn = blas_turn(m.L);
  return cholmod().solve2(CHOLMOD_A, m.L, &b, nullptr, &m.X, nullptr, &m.Y, &m.E, &m.common);
}

bool SparseCholesky::solve(const VertexMatrix& B, VertexMatrix& X) const {
  Impl& m = *impl_;
  if (!m.factored || B.rows() != m.rows) return false;
  X.resize(m.rows, 3);
  if (m.rows == 0) return true;
  const std::size_t n = static_cast<std::size_t>(m.rows);
  m.columns.resize(3 * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < 3; ++k) m.columns[k * n + i] = B(static_cast<Eigen::Index>(i), k);
  if (!solve_columns(3)) return false;
  const double* x = static_cast<const double*>(m.X->x);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < 3; ++k) X(static_cast<Eigen::Index>(i), k) = x[k * m.X->d + i];
  return true;
}

bool SparseCholesky::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) const {
  Impl& m = *impl_;
  if (!m.factored || b.size() != m.rows) return false;
  x.resize(m.rows);
  if (m.rows == 0) return true;
  m.columns.assign(b.data(), b.data() + b.size());
  if (!solve_columns(1)) return false;
  std::copy_n(static_cast<const double*>(m.X->x), m.rows, x.data());
  return true;
}

double SparseCholesky::factor_entries() const { return impl_->common.lnz; }

std::vector<int> SparseCholesky::order() const {
  const Impl& m = *impl_;
  if (m.rows <= 0) return {};
  const int* const first = static_cast<const int*>(m.L->Perm);
  return {first, first + m.rows};
}

void multiply(const SymmetricMatrix& A, const VertexMatrix& x, VertexMatrix& y) {
  y.setZero(A.rows(), 3);
  for (int c = 0; c < A.outerSize(); ++c) {
    const double x0 = x(c, 0), x1 = x(c, 1), x2 = x(c, 2);
    double y0 = 0, y1 = 0, y2 = 0;
    for (SymmetricMatrix::InnerIterator it(A, c); it; ++it) {
      const int r = it.row();
      const double a = it.value();
      y(r, 0) += a * x0, y(r, 1) += a * x1, y(r, 2) += a * x2;
      if (r != c) y0 += a * x(r, 0), y1 += a * x(r, 1), y2 += a * x(r, 2);
    }
    y(c, 0) += y0, y(c, 1) += y1, y(c, 2) += y2;
  }
}

}  // namespace overtet
