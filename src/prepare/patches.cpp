#include "src/prepare/patches.h"

#include <algorithm>
#include <set>
#include <unordered_map>
#include <utility>

#include "kernels/bvh/self_intersections.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

// Some faces with their vertices numbered anew.
struct Excerpt {
  Surface surface;
  std::vector<Index> patch_of;  // #F: or -1: the surface
  std::vector<Index> face;      // #F: number in the surface, or in the patch
};

class Trial {
 public:
  Trial(WorkingSurface& working, const std::vector<Patch>& patches, const RunContext& context)
      : working_(working), patches_(patches), context_(context), fate_(patches.size(), PatchFate::taken) {
    for (const Patch& p : patches) {
      first_point_.push_back(static_cast<Index>(points_.size()));
      points_.insert(points_.end(), p.points.begin(), p.points.end());
    }
    is_old_.assign(working.surface.F.rows(), 0);
    for (const Patch& p : patches)
      for (const Index f : p.old_faces) is_old_[f] = 1;
  }

  Result<std::vector<PatchFate>> run(bool allow_crossings) {
    near_ = faces_near_patches();
    if (auto stop = context_.stop()) return *stop;
    const Excerpt all = excerpt(false);
    leave_out_flat(all);
    leave_out_crowded(all);
    if (!allow_crossings) {
      if (auto stop = context_.stop()) return *stop;
      leave_out_crossing(all);
    }
    put();
    return std::move(fate_);
  }

 private:
  const Surface& surface() const { return working_.surface; }
  // Of a corner of a patch.
  Index global(std::size_t p, Index corner) const {
    return corner >= 0 ? corner : static_cast<Index>(surface().V.rows()) + first_point_[p] - 1 - corner;
  }
  Eigen::Vector3d position(Index v) const {
    const Index n = static_cast<Index>(surface().V.rows());
    if (v >= n) return points_[v - n];
    return surface().V.row(v).transpose();
  }
  static void stretch(Box& box, const Eigen::Vector3d& p) {
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::min(box.low[k], p[k]);
      box.high[k] = std::max(box.high[k], p[k]);
    }
  }
  template <class At>
  static Box box_of(const At& at) {
    const Eigen::Vector3d p = at(0);
    Box box{{p[0], p[1], p[2]}, {p[0], p[1], p[2]}};
    stretch(box, at(1));
    stretch(box, at(2));
    return box;
  }

  // Faces of the surface that stay, whose boxes meet that of a patch's face.
  std::vector<Index> faces_near_patches() const {
    std::vector<Box> boxes;
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      for (const auto& f : patches_[p].faces)
        boxes.push_back(box_of([&](int k) { return position(global(p, f[k])); }));
      for (const Index f : patches_[p].old_faces)
        boxes.push_back(box_of([&](int k) { return position(surface().F(f, k)); }));
    }
    BoxTree tree;
    tree.build(boxes);
    return parallel_collect<Index>(
        surface().F.rows(), kMediumGrain, [&](std::int64_t begin, std::int64_t end, std::vector<Index>& out) {
          for (auto f = static_cast<Index>(begin); f < end; ++f) {
            if (is_old_[f]) continue;
            const Box box = box_of([&](int k) { return position(surface().F(f, k)); });
            bool near = false;
            tree.query_box(box.low, box.high, [&](Index) { near = true; });
            if (near) out.push_back(f);
          }
        });
  }

  // The faces near patches, and those of the patches: the new ones, or the old ones of those that cross.
  Excerpt excerpt(bool old) const {
    Excerpt e;
    std::unordered_map<Index, Index> number;
    std::vector<Index> corners, vertices;
    const auto add = [&](Index patch, Index face, const auto& vertex) {
      e.patch_of.push_back(patch);
      e.face.push_back(face);
      for (int k = 0; k < 3; ++k) {
        const auto [at, is_new] = number.try_emplace(vertex(k), static_cast<Index>(vertices.size()));
        if (is_new) vertices.push_back(vertex(k));
        corners.push_back(at->second);
      }
    };
    for (const Index f : near_) add(-1, f, [&](int k) { return surface().F(f, k); });
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      const auto patch = static_cast<Index>(p);
      if (old && fate_[p] == PatchFate::crossing)
        for (const Index f : patches_[p].old_faces) add(patch, f, [&](int k) { return surface().F(f, k); });
      for (std::size_t i = 0; !old && i < patches_[p].faces.size(); ++i)
        add(patch, static_cast<Index>(i), [&](int k) { return global(p, patches_[p].faces[i][k]); });
    }
    e.surface.V.resize(static_cast<Index>(vertices.size()), 3);
    for (std::size_t v = 0; v < vertices.size(); ++v)
      e.surface.V.row(static_cast<Index>(v)) = position(vertices[v]).transpose();
    e.surface.F = Eigen::Map<const TriangleMatrix>(corners.data(), static_cast<Index>(corners.size() / 3), 3);
    return e;
  }

  void leave_out(Index patch, PatchFate fate) {
    if (patch >= 0 && fate_[patch] == PatchFate::taken) fate_[patch] = fate;
  }

  void leave_out_flat(const Excerpt& all) {
    for (const Index f : degenerate_faces(all.surface)) leave_out(all.patch_of[f], PatchFate::flat);
  }

  // Edges of a patch that have more than two faces.
  void leave_out_crowded(const Excerpt& all) {
    const TriangleMatrix& F = all.surface.F;
    const auto key = [&](Index h) {
      const auto [a, b] = std::minmax({half_edge_source(F, h), half_edge_target(F, h)});
      return (static_cast<std::int64_t>(a) << 32) | b;
    };
    std::unordered_map<std::int64_t, int> count;
    for (Index h = 0; h < 3 * F.rows(); ++h)
      if (all.patch_of[half_edge_face(h)] >= 0) count.try_emplace(key(h), 0);
    for (Index h = 0; h < 3 * F.rows(); ++h)
      if (const auto at = count.find(key(h)); at != count.end()) ++at->second;
    for (Index h = 0; h < 3 * F.rows(); ++h)
      if (const Index p = all.patch_of[half_edge_face(h)]; p >= 0 && count.at(key(h)) > 2)
        leave_out(p, PatchFate::crowded);
  }

  static std::vector<FacePair> crossings_of_patches(const Excerpt& e) {
    SelfIntersectionOptions options;
    options.active.resize(e.patch_of.size());
    for (std::size_t f = 0; f < e.patch_of.size(); ++f) options.active[f] = e.patch_of[f] >= 0;
    return find_self_intersections(e.surface.V, e.surface.F, options);
  }

  // Patch and face of the surface; those pairs only.
  static std::set<std::pair<Index, Index>> with_surface(const Excerpt& e,
                                                        const std::vector<FacePair>& pairs) {
    std::set<std::pair<Index, Index>> found;
    for (const auto& [f, g] : pairs)
      if ((e.patch_of[f] < 0) != (e.patch_of[g] < 0))
        e.patch_of[f] < 0 ? found.emplace(e.patch_of[g], e.face[f]) : found.emplace(e.patch_of[f], e.face[g]);
    return found;
  }

  void leave_out_crossing(const Excerpt& all) {
    const std::vector<FacePair> pairs = crossings_of_patches(all);
    const auto now = with_surface(all, pairs);
    for (const auto& [patch, face] : now) leave_out(patch, PatchFate::crossing);
    if (!now.empty()) {
      const Excerpt before = excerpt(true);
      const auto old = with_surface(before, crossings_of_patches(before));
      std::vector<char> more(patches_.size(), 0);
      for (const auto& pair : now)
        if (!old.contains(pair)) more[pair.first] = 1;
      for (std::size_t p = 0; p < patches_.size(); ++p)
        if (fate_[p] == PatchFate::crossing && !more[p]) fate_[p] = PatchFate::taken;
    }
    std::set<std::pair<Index, Index>> together;
    for (const auto& [f, g] : pairs) {
      const Index p = all.patch_of[f], q = all.patch_of[g];
      if (p < 0 || q < 0) continue;
      if (p == q)
        leave_out(p, PatchFate::crossing);
      else
        together.emplace(std::max(p, q), std::min(p, q));
    }
    for (const auto& [later, earlier] : together)  // by the later one: the earlier ones are decided
      if (fate_[earlier] == PatchFate::taken) leave_out(later, PatchFate::crossing);
  }

  void put() {
    Surface& s = working_.surface;
    std::vector<char> gone(s.F.rows(), 0);
    Index points = 0, faces = static_cast<Index>(s.F.rows());
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      if (fate_[p] != PatchFate::taken) continue;
      points += static_cast<Index>(patches_[p].points.size());
      faces +=
          static_cast<Index>(patches_[p].faces.size()) - static_cast<Index>(patches_[p].old_faces.size());
      for (const Index f : patches_[p].old_faces) gone[f] = 1;
    }
    Index n = 0;
    for (Index f = 0; f < s.F.rows(); ++f) {
      if (gone[f]) continue;
      if (n != f) s.F.row(n) = s.F.row(f), working_.face_of[n] = working_.face_of[f];
      ++n;
    }
    Index v = static_cast<Index>(s.V.rows());
    s.V.conservativeResize(v + points, 3);
    s.F.conservativeResize(faces, 3);
    working_.vertex_of.resize(v + points, -1);
    working_.face_of.resize(faces, -1);
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      if (fate_[p] != PatchFate::taken) continue;
      const Patch& patch = patches_[p];
      for (std::size_t i = 0; i < patch.faces.size(); ++i, ++n) {
        for (int k = 0; k < 3; ++k)
          s.F(n, k) = patch.faces[i][k] >= 0 ? patch.faces[i][k] : v - 1 - patch.faces[i][k];
        working_.face_of[n] = patch.face_of[i];
      }
      for (const Eigen::Vector3d& point : patch.points) s.V.row(v++) = point.transpose();
    }
  }

  WorkingSurface& working_;
  const std::vector<Patch>& patches_;
  const RunContext& context_;
  std::vector<PatchFate> fate_;
  std::vector<Index> first_point_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<char> is_old_;
  std::vector<Index> near_;
};

}  // namespace

Result<std::vector<PatchFate>> put_patches(WorkingSurface& working, const std::vector<Patch>& patches,
                                           bool allow_crossings, const RunContext& context) {
  if (patches.empty()) return std::vector<PatchFate>{};
  return Trial(working, patches, context).run(allow_crossings);
}

}  // namespace overtet
