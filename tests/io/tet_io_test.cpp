
#include "overtet/io.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <random>
#include <sstream>

#include "src/io/file.h"
#include "tests/support/files.h"

namespace overtet {
namespace {

using test::TemporaryFolder;

TetMesh sample(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  TetMesh m;
  m.V.resize(60, 3);
  for (Eigen::Index i = 0; i < m.V.size(); ++i)
    m.V.data()[i] = (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5) *
                    std::ldexp(1, static_cast<int>(random() % 40) - 20);
  m.V(0, 0) = 0x1.fffffffffffffp+200;
  m.V(1, 1) = 0x0.0000000000001p-1022;
  m.V(2, 2) = -1.0 / 3;
  m.T.resize(50, 4);
  for (Index t = 0; t < 50; ++t)
    for (Index k = 0; k < 4; ++k) m.T(t, k) = (t + 3 * k) % 60;
  m.T(49, 0) = 59;
  return m;
}

void expect_same(const TetMesh& a, const TetMesh& b) {
  ASSERT_EQ(a.V.rows(), b.V.rows());
  EXPECT_EQ(std::memcmp(a.V.data(), b.V.data(), sizeof(double) * static_cast<std::size_t>(a.V.size())), 0);
  EXPECT_EQ(a.T, b.T);
}

struct Case {
  const char* name;
  TetFormat format;
  const char* readers;
};
const Case kCases[] = {{"a.mesh", TetFormat::medit, "meshio"},
                       {"b.msh", TetFormat::gmsh22, "meshio gmsh"},
                       {"c.msh", TetFormat::gmsh41, "meshio gmsh"},
                       {"d.vtu", TetFormat::vtu, "meshio vtk"},
                       {"e.node", TetFormat::tetgen, "meshio"},
                       {"f.inp", TetFormat::abaqus, ""},  // others do not see the exact numbers
                       {"g.vtk", TetFormat::vtk, "meshio vtk"}};

TEST(TetIo, WrittenMeshesReadBackToTheBit) {
  const TemporaryFolder folder;
  const TetMesh m = sample(1);
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.name);
    ASSERT_TRUE(write_tets(folder.file(c.name), m, c.format).ok());
    const Result<TetMesh> r = read_tets(folder.file(c.name));
    ASSERT_TRUE(r.ok()) << r.error().message;
    expect_same(m, r.value());
  }
  const Result<TetMesh> by_ele = read_tets(folder.file("e.ele"));
  ASSERT_TRUE(by_ele.ok());
  expect_same(m, by_ele.value());
  EXPECT_EQ(folder.entries(), 8);
}

TEST(TetIo, OtherProgramsReadTheSame) {
  const TemporaryFolder folder;
  TetMesh m = sample(2);
  // Gmsh measures the box of what it reads; keep it finite for its arithmetic.
  m.V(0, 0) = 0.1;
  for (const Case& c : kCases) {
    ASSERT_TRUE(write_tets(folder.file(c.name), m, c.format).ok());
    std::istringstream readers(c.readers);
    for (std::string reader; readers >> reader;) {
      SCOPED_TRACE(std::string(c.name) + " with " + reader);
      const auto r =
          test::shell("/usr/bin/python3 " OVERTET_READ_BACK " " + reader + " " + folder.file(c.name));
      ASSERT_EQ(r.exit_code, 0) << r.err;
      // Libraries may talk before they answer.
      std::istringstream in(r.out);
      TetMesh got;
      Eigen::Index vertices = -1, tets = -1;
      for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        std::string rest;
        if (words >> vertices >> tets && !(words >> rest)) break;
      }
      ASSERT_EQ(vertices, m.V.rows());
      ASSERT_EQ(tets, m.T.rows());
      got.V.resize(vertices, 3);
      got.T.resize(tets, 4);
      std::string word;
      for (Eigen::Index i = 0; i < got.V.size() && in >> word; ++i)
        got.V.data()[i] = std::strtod(word.c_str(), nullptr);
      for (Eigen::Index i = 0; i < got.T.size(); ++i) in >> got.T.data()[i];
      ASSERT_TRUE(static_cast<bool>(in));
      expect_same(m, got);
    }
  }
}

TEST(TetIo, ReadsWhatOthersWrite) {
  const TemporaryFolder folder;
  test::write_text(
      folder.file("a.mesh"),
      "MeshVersionFormatted 1\nDimension\n3\n# comment\nVertices 4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n"
      "Triangles\n1\n1 2 3 4\nTetrahedra 1\n1 2 3 4 7\nEnd\n");
  test::write_text(folder.file("a.node"),
                   "# nodes\n4 3 1 1\n1 0 0 0 5 1\n2 1 0 0 5 1\n3 0 1 0 5 1\n4 0 0 1 5 1\n");
  test::write_text(folder.file("a.ele"), "1 4 1\n1 1 2 3 4 9\n");
  test::write_text(
      folder.file("a.msh"),
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"x\"\n$EndPhysicalNames\n$Nodes\n4\n"
      "10 0 0 0\n20 1 0 0\n30 0 1 0\n40 0 0 1\n$EndNodes\n$Elements\n2\n1 2 2 0 1 10 20 30\n"
      "2 4 2 0 1 10 20 30 40\n$EndElements\n");
  test::write_text(
      folder.file("a.vtu"),
      "<?xml version='1.0'?><VTKFile type='UnstructuredGrid' version='0.1' byte_order='LittleEndian'>"
      "<UnstructuredGrid><Piece NumberOfPoints='4' NumberOfCells='1'><PointData/><Points>"
      "<DataArray type='Float32' NumberOfComponents='3' format='ascii'>0 0 0 1 0 0 0 1 0 0 0 "
      "1</DataArray></Points>"
      "<Cells><DataArray type='Int32' Name='connectivity' format='ascii'>0 1 2 3</DataArray>"
      "<DataArray type='Int32' Name='offsets' format='ascii'>4</DataArray>"
      "<DataArray type='UInt8' Name='types' "
      "format='ascii'>10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>");
  for (const char* name : {"a.mesh", "a.node", "a.msh", "a.vtu"}) {
    const Result<TetMesh> r = read_tets(folder.file(name));
    ASSERT_TRUE(r.ok()) << r.error().message;
    EXPECT_EQ(r.value().V.rows(), 4) << name;
    EXPECT_EQ(r.value().V(2, 1), 1) << name;
    EXPECT_EQ(r.value().T, (TetMatrix(1, 4) << 0, 1, 2, 3).finished()) << name;
  }
}

TEST(TetIo, DamagedFilesNeverCrash) {
  const std::uint64_t seed = 77;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  const TemporaryFolder folder;
  for (const Case& c : kCases) {
    ASSERT_TRUE(write_tets(folder.file(c.name), sample(3), c.format).ok());
    const std::string good = test::read_text(folder.file(c.name));
    for (int i = 0; i < 200; ++i) {
      std::string bad = good;
      if (i % 2 == 0) bad.resize(random() % bad.size());
      for (int k = 0; k < i % 4 && !bad.empty(); ++k)
        bad[random() % bad.size()] = static_cast<char>(random());
      test::write_text(folder.file(c.name), bad);
      const Result<TetMesh> r = read_tets(folder.file(c.name));
      if (!r.ok()) continue;
      EXPECT_GE(r.value().T.minCoeff(), 0);
      EXPECT_LT(r.value().T.maxCoeff(), r.value().V.rows());
    }
  }
}

TEST(TetIo, AnOutputAppearsWholeOrNotAtAll) {
  const TemporaryFolder folder;
  const std::string path = folder.file("a.txt");
  test::write_text(path, "old");
  {
    AtomicFile file;
    ASSERT_TRUE(file.open(path).ok());
    ASSERT_TRUE(file.write("new").ok());
    EXPECT_EQ(test::read_text(path), "old");
  }  // not committed
  EXPECT_EQ(test::read_text(path), "old");
  EXPECT_EQ(folder.entries(), 1);
  AtomicFile file;
  ASSERT_TRUE(file.open(path).ok());
  ASSERT_TRUE(file.write("new").ok());
  ASSERT_TRUE(file.commit().ok());
  EXPECT_EQ(test::read_text(path), "new");
  EXPECT_EQ(folder.entries(), 1);

  // A link stays a link; what it points to changes.
  ASSERT_EQ(symlink("a.txt", folder.file("link.txt").c_str()), 0);
  AtomicFile linked;
  ASSERT_TRUE(linked.open(folder.file("link.txt")).ok());
  ASSERT_TRUE(linked.write("newer").ok());
  ASSERT_TRUE(linked.commit().ok());
  EXPECT_EQ(test::read_text(path), "newer");
  struct stat info;
  ASSERT_EQ(lstat(folder.file("link.txt").c_str(), &info), 0);
  EXPECT_TRUE(S_ISLNK(info.st_mode));

  // What is not a file is written to, never replaced.
  AtomicFile null;
  ASSERT_TRUE(null.open("/dev/null").ok());
  ASSERT_TRUE(null.write("x").ok());
  ASSERT_TRUE(null.commit().ok());
  ASSERT_EQ(stat("/dev/null", &info), 0);
  EXPECT_TRUE(S_ISCHR(info.st_mode));

  AtomicFile nowhere;
  EXPECT_EQ(nowhere.open(folder.file("no/such/folder")).error().code, ErrorCode::io);
  EXPECT_EQ(nowhere.open(folder.path()).error().code, ErrorCode::io);
}

// A signal that nobody has asked for ends the program.
TEST(AtomicFile, APipeWhoseReaderHasGoneIsAnErrorAndNoSignal) {
  const test::TemporaryFolder folder;
  const std::string path = folder.file("p");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  struct sigaction plain {};
  plain.sa_handler = SIG_DFL;
  struct sigaction before {};
  ASSERT_EQ(sigaction(SIGPIPE, &plain, &before), 0);
  const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  AtomicFile file;
  ASSERT_TRUE(file.open(path).ok());
  EXPECT_TRUE(file.write("something").ok());
  ::close(reader);
  for (int i = 0; i < 2; ++i) {
    const Status s = file.write("more");
    ASSERT_FALSE(s.ok());
    EXPECT_EQ(s.error().code, ErrorCode::io);
  }
  sigset_t pending, blocked;
  sigpending(&pending);
  pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
  EXPECT_EQ(sigismember(&pending, SIGPIPE), 0);
  EXPECT_EQ(sigismember(&blocked, SIGPIPE), 0);
  // Nobody has begun to read.
  AtomicFile again;
  const Status s = again.open(path);
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().code, ErrorCode::io);
  sigaction(SIGPIPE, &before, nullptr);
}

}  // namespace
}  // namespace overtet
