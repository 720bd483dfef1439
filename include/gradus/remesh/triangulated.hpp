/// Meshes a triangulated surface with the sizes of a control space, by local operations on its smooth support.
#pragma once

#include "gradus/remesh/parametric.hpp"
#include "gradus/remesh/support.hpp"
#include "gradus/surface/smooth_support.hpp"

namespace gradus {

/// The smooth surface over a triangulation, its feature curves and sizes. A place is a triangle with the barycentric
/// coordinates of corners 1 and 2; a feature curve is a chain with its arc length along the edges. Not for several
/// threads at once.
class TriangleSupport final : public Support {
  public:
    /// All must outlive this.
    TriangleSupport(const SmoothSupport& surface, const Features& features);
    std::optional<Foot> move(const Place& from, const Eigen::Vector3d& point,
                             const Eigen::Vector3d& target) const override;
    std::optional<Foot> between(const Place& a, const Place& b, const Eigen::Vector3d& up) const override;
    void settle(Foot& foot, double size) const override;
    std::optional<Foot> slide(const Place& from, const Eigen::Vector3d& target) const override;
    int chain_of(int curve) const override { return curve; }
    Foot middle(int chain, const Foot& a, const Foot& b) const override;
    /// The place of a vertex of the triangulation. @param cell  a triangle of the control space at it
    Foot at_vertex(int vertex, int cell) const;

  private:
    struct Curve {
        std::vector<double> length;  // from the start to each vertex, to the end of a closed one too
        std::vector<int> halfedges;  // one per edge
        bool closed = false;

        double end() const { return length.back(); }
    };
    std::pair<int, double> edge_at(int curve, double t) const;
    template <class Use>
    void for_each_holder(const Place& place, const Use& use) const;
    Eigen::Vector3d on_facet(int triangle, const std::array<double, 3>& weights) const;
    Place on_curve(int curve, double t, int cell) const;
    Eigen::Vector3d point_at(const Place& place) const;
    Foot foot(const Place& place) const;
    Foot foot_of(Foot foot) const;
    std::pair<int, int> sides_at(const Place& place, std::array<Eigen::Vector3d, 2>& normals) const;
    void spread_normals(Foot& foot, double reach) const;
    void spread_over_sides(Foot& foot, double reach) const;
    void list_near(const Foot& foot, double reach) const;
    std::pair<Eigen::Vector3d, Eigen::Vector3d> farthest_apart(const Eigen::Vector3d& normal) const;
    const GregoryPatch& patch(int triangle) const;

    const SmoothSupport& surface_;
    const Features& features_;
    std::vector<Curve> curves_;
    // Patches that were asked for last: the operations stay in one place for long. So only one thread may use it.
    struct Kept {
        int triangle = -1;
        GregoryPatch patch;
    };
    mutable std::vector<Kept> kept_;
    struct Part {
        int triangle;
        Eigen::Vector3d begin;
    };
    struct Near {
        int triangle;
        Eigen::Vector3d normal;
    };
    class Section;
    Foot in_line(const Foot& half, const Place& a, const Place& b) const;

    mutable std::vector<Near> near_;     // room for `list_near`
    mutable std::vector<Part> section_;  // room for `between`
    mutable std::vector<int> goals_;
    std::vector<std::pair<int, double>> curve_of_;  // of each vertex inside a chain: chain and arc length; else -1
};

/// A triangulation with what is known of it.
struct TriangulatedSurface {
    const SmoothSupport& support;
    const Features& features;
    std::span<const int> labels{};               ///< of its triangles, or empty
    const RequiredElements* required = nullptr;  ///< vertices, edges and triangles of it that are kept bit for bit;
                                                 ///< null: none. Sizes are not to be far below them, see raise_to_held
};

enum class MeshStage { Draft, Final };

/// Some triangles of a mesh in numbers of their own: those that changed, and after them those around.
struct MeshPart {
    std::vector<Eigen::Vector3d> points;
    std::vector<SurfacePoint> places;  ///< on the triangulation
    std::vector<Triangle> triangles;
    int changed = 0;                            ///< number of the first triangles
    std::optional<Eigen::Vector3d> fault = {};  ///< a point of the triangulation where the mesh was not good
};

/// A place where a mesh is too far from the triangulation.
struct MeshFault {
    Eigen::Vector3d point;       ///< of the triangulation
    double distance = 0;         ///< largest seen, unit of length
    std::vector<int> triangles;  ///< of the mesh there
};

/// Looks at meshes while they are made.
class MeshChecks {
  public:
    virtual ~MeshChecks() = default;
    /// Whether meshes may have faults. If not there are no drafts, and the map is left only around elements that fall
    /// short without a cause.
    virtual bool has_limit() const { return true; }
    /// Where a mesh that may be the last is not good. Of the meshes that this is called for the last is the result; it
    /// may be called for one twice.
    virtual std::vector<MeshFault> faults_of(const SurfaceMesh&) { return {}; }
    /// What sizes at its vertices to go on with, or nothing where the mesh is good. Called for drafts first, then for
    /// meshes that may be the last, after `faults_of`.
    /// @param in_vain  places where lower sizes broke the mesh, which was put back there: lower ones are not to be
    /// asked for again
    virtual std::optional<std::vector<double>> sizes_after(const SurfaceMesh& mesh, MeshStage stage,
                                                           std::span<const Eigen::Vector3d> in_vain) = 0;
    /// Sizes at the vertices of a first draft that is good, those that it has or what they are to be: the map of the
    /// meshes to come.
    virtual std::vector<double> sizes_of_draft(const SurfaceMesh& mesh) { return mesh.sizes; }
    /// Places where a mesh touches or passes through itself, and the triangulation does not. Called for the last mesh
    /// last.
    virtual std::vector<Eigen::Vector3d> contacts_of(const SurfaceMesh&) { return {}; }
    /// Sizes to go on with that are smaller by a factor around some places, or nothing where they cannot be.
    virtual std::optional<std::vector<double>> sizes_below(const SurfaceMesh&, std::span<const Eigen::Vector3d>,
                                                           double /*factor*/) {
        return std::nullopt;
    }
    /// These, and what was asked for after them, led to no better mesh and are given up.
    virtual void take_back() {}
    /// Whether a mesh is good where triangles were replaced by those that changed, as far as can be told from these.
    virtual bool allows(const MeshPart&) { return true; }
};

/// Whether a vertex of some size is around one of these places: within three sizes.
bool is_around(const Eigen::Vector3d& p, double size, std::span<const Eigen::Vector3d> places);

/// Splits, collapses, flips and moves the triangulation's own mesh until it has the sizes asked for; its features,
/// corners and topology are kept, and so is what is required. Places of the result name triangles of the triangulation.
/// @param control  not looked at any more once `checks` is called: it may be gone by then
/// @param cells    for each vertex of the triangulation, first of all, a triangle of the control space at it
/// @param options  `goal` is for meshes without a limit: with one no more than .75 is sought on the way, and .82 in the
/// end; `threads` does
///                 not matter, as only one works
/// @param checks   null: none
/// @throws std::invalid_argument for required elements as frozen_elements does, and where there are fewer cells than
/// vertices, or labels are not one per triangle
/// @throws std::length_error naming the estimate when the map asks for more than max_triangles
/// @throws std::invalid_argument for a size below 1e-9 of the coordinates there
RemeshResult remesh(const TriangulatedSurface& surface, const ControlSpace& control, std::span<const int> cells,
                    const RemeshOptions& options = {}, MeshChecks* checks = nullptr);

}  // namespace gradus
