/// Triangles to quadrilaterals: the best pairing of all, then topology and positions are mended. [Borouchaki & Frey
/// 1998; pairing as by Remacle et al. 2012]
#pragma once

#include "gradus/control/tensor.hpp"
#include "gradus/mesh/soup.hpp"

#include <array>
#include <span>
#include <vector>

namespace gradus {

/// Quadrilaterals, and triangles that are left. Corners run counter-clockwise, as those of the triangles did.
struct QuadMesh {
    std::vector<Eigen::Vector3d> points;
    std::vector<std::array<int, 4>> quads;
    std::vector<Triangle> triangles;
    std::vector<int> quad_labels = {}, triangle_labels = {};  ///< one per element, or empty
    std::vector<std::array<int, 2>> edges = {};               ///< feature edges of the triangles
    std::vector<int> edge_labels = {};
    std::vector<int> corners = {};
    std::vector<Tensor> metrics = {};  ///< at the vertices, where some were given and no edge is halved
    int dimension = 3;
};

struct QuadOptions {
    enum class Mode {
        Dominant,  ///< triangles stay where a quadrilateral would be bad
        All,       ///< none stays in a part whose number of triangles is even; boundaries and features keep their edges
        Refined    ///< every edge is halved: quadrilaterals only, four for each, three for a triangle that is left
    };
    Mode mode = Mode::Dominant;
    std::span<const Tensor> metrics{};  ///< one per vertex: shapes are judged in them; empty: as they are
};

struct QuadStatistics {
    int paired = 0;                    ///< quadrilaterals by the matching
    int led = 0;                       ///< triangles that were led to others over a path
    int odd_parts = 0;                 ///< parts, as features bound them, with an odd number of triangles
    int collapses = 0, rotations = 0;  ///< of the mending of the topology
};

/// Quality of a quadrilateral: the least of the four ratios of the Jacobian to the lengths of the two edges at a
/// corner, 1 for a rectangle, 0 or less where it is not convex. In a metric: that of the mean of its corners' ones.
double quad_quality(const std::array<Eigen::Vector3d, 4>& corners, const Eigen::Vector3d& normal);
double quad_quality(const std::array<Eigen::Vector3d, 4>& corners, const std::array<Tensor, 4>& metrics,
                    const Eigen::Vector3d& normal);

/// Pairs stay on one side of feature edges, boundaries of labels and open edges. Vertices on those stay where they are,
/// as do corners and what is required; others move on the surface of the triangles.
/// @throws std::invalid_argument for a soup that is no oriented manifold, or metrics that are not one per vertex
QuadMesh to_quads(const TriangleSoup& soup, const QuadOptions& options = {}, QuadStatistics* statistics = nullptr);

}  // namespace gradus
