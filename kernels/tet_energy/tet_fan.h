// Tets with a common apex, and how good they are for many places of it: four tets at a time, with AVX2 where the
// processor has it. The numbers are those of min_dihedral_sine(), to the last bit, with or without.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace overtet {

// One thread at a time.
class TetFan {
 public:
  TetFan();
  ~TetFan();
  TetFan(TetFan&&) noexcept;
  TetFan& operator=(TetFan&&) noexcept;

  void clear();
  // The tet (a, b, c, apex). Its quality counts with this factor.
  void add(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, double weight = 1);
  // What add() was called for, in order, with the apex at x: the factor times min_dihedral_sine().
  const std::vector<double>& qualities_at(const Eigen::Vector3d& x);
  // The least of them; some value <= stop where it is not above stop. Where one tet fell short, it is looked at
  // sooner the next time.
  double worst_at(const Eigen::Vector3d& x, double stop);
  // The sines (times their factors) within `factor` of the least one, and the gradients of their logarithms with
  // respect to the apex; see dihedral_sines().
  struct Sine {
    double sine;
    Eigen::Vector3d log_gradient;
  };
  void sines_near_worst(const Eigen::Vector3d& x, double factor, std::vector<Sine>& out);

 private:
  struct Block;
  struct Lane {
    Eigen::Vector3d a, b, c;
    double weight;
  };
  double exact(std::size_t lane, const Eigen::Vector3d& x) const;
  std::vector<Lane> lanes_;
  std::vector<Block> blocks_;
  std::vector<std::size_t> order_;  // of the blocks
  std::vector<double> qualities_;
};

}  // namespace overtet
