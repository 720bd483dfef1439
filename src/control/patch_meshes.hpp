/// Meshes of the patches of a model between cut curves, put together: what backgrounds and meshes begin with. Private
/// to the sources.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "gradus/mesh/tri_mesh.hpp"
#include "gradus/surface/surface_model.hpp"

namespace gradus {

/// The curves of a model cut into pieces, and numbers for the vertices that patches share: model vertices first, then
/// the inner points of each curve.
struct CutCurves {
    std::vector<std::vector<double>> t;  ///< parameters along each curve, from 0 to 1; none, or some, of a pole
    std::vector<int> first;              ///< number of the first inner point of each curve
    int count = 0;

    CutCurves(const SurfaceModel& model, std::vector<std::vector<double>> parameters);
    int number(const SurfaceModel& model, int curve, int i) const;
};

/// As many pieces of curves as make a mesh: three of one that returns to its start, two of a seam, as the patch lies on
/// both its sides, and of the second of two curves between the same vertices; none of a pole stays none.
void cut_into_polygons(const SurfaceModel& model, std::vector<int>& pieces);

/// Parameters that cut a curve into pieces of the same length. @param length  that from t[0] = 0 to each t
std::vector<double> equal_pieces(std::span<const double> t, std::span<const double> length, int pieces);

/// The mesh of one patch: shared vertices by their number, inner ones numbered after those of all patches.
struct PatchMesh {
    std::vector<Eigen::Vector2d> uv;
    std::vector<int> cell;    ///< what the size left as its hint at each point
    std::vector<int> number;  ///< of the vertex in the whole mesh
    std::vector<std::array<int, 3>> triangles;
    std::vector<std::array<int, 2>> poles;  ///< segments that are a point in space
};

/// Size wanted at a point of a patch, with a hint for the next call nearby, -1 at first.
using PatchSize = std::function<double(const SurfacePoint& at, const Eigen::Vector3d& point, int& hint)>;

/// Patches are meshed one by one in their parameters, on all threads. Edges inside patches that two patches would
/// share, or that join a vertex to itself (on a seam), are cut: the same two vertices may have only one edge. Triangles
/// on the side of a pole have lost that side and vanish.
class PatchMeshes {
  public:
    /// @throws std::length_error where a patch would get more than most_points
    PatchMeshes(const SurfaceModel& model, const CutCurves& curves, const PatchSize& size,
                std::size_t most_points = 50'000'000);

    int num_vertices() const { return count_; }
    const std::vector<PatchMesh>& patches() const { return patches_; }
    /// Calls visit(patch, corners by their place in the mesh of the patch), turned outward.
    template <class Visit>
    void for_each_triangle(const Visit& visit) const {
        for (int p = 0; p < static_cast<int>(patches_.size()); ++p)
            for (auto t : patches_[p].triangles) {
                const std::vector<int>& number = patches_[p].number;
                if (number[t[0]] == number[t[1]] || number[t[1]] == number[t[2]] || number[t[2]] == number[t[0]])
                    continue;
                if (model_.flipped(p)) std::swap(t[1], t[2]);
                visit(p, t);
            }
    }
    std::vector<Triangle> triangles() const;

  private:
    PatchMesh mesh_patch(int p, const CutCurves& curves, const PatchSize& size, std::size_t most_points) const;
    void number_inner(PatchMesh& mesh);
    bool is_pole(int p, int a, int b) const;
    bool cut_conflicts();
    void split_twin_triangles();

    const SurfaceModel& model_;
    std::vector<PatchMesh> patches_;
    int shared_;  // vertices that patches share: the first ones
    int count_;
};

}  // namespace gradus
