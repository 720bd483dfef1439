#include "gradus/surface/t_junctions.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <stdexcept>

#include "trace.hpp"

namespace gradus {
namespace {

struct BoundaryTrace {
    const SurfaceModel* model;
    int curve;

    Eigen::Vector3d point(double t) const { return model->curve_point(curve, t); }
    Eigen::Vector3d derivative(double t) const { return model->curve_jet(curve, t).d; }
};

struct BoundaryCurve {
    int curve;
    BoundaryTrace trace;
    Eigen::AlignedBox3d box;  ///< of samples, widened so as to hold the curve
};

std::vector<BoundaryCurve> boundary_of(const SurfaceModel& model, double tolerance) {
    std::vector<BoundaryCurve> result;
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c) {
        const ModelCurve& curve = model.curves()[c];
        if (curve.kind != CurveKind::Boundary) continue;
        BoundaryCurve b{c, {&model, c}, {}};
        for (int k = 0; k <= curve_pieces; ++k) b.box.extend(b.trace.point(static_cast<double>(k) / curve_pieces));
        const Eigen::Vector3d margin = Eigen::Vector3d::Constant(tolerance) + b.box.sizes() / curve_pieces;
        b.box = Eigen::AlignedBox3d(b.box.min() - margin, b.box.max() + margin);
        result.push_back(b);
    }
    return result;
}

}  // namespace

std::vector<TJunction> find_t_junctions(const SurfaceModel& model, double tolerance) {
    if (!(tolerance > 0)) throw std::invalid_argument("find_t_junctions: tolerance must be positive");
    const double distance = tolerance * model.diagonal();
    const std::vector<BoundaryCurve> boundary = boundary_of(model, distance);
    std::set<int> vertices;
    for (const BoundaryCurve& b : boundary)
        vertices.insert(model.curves()[b.curve].ends.begin(), model.curves()[b.curve].ends.end());

    std::vector<TJunction> result;
    for (const int vertex : vertices) {
        const Eigen::Vector3d& p = model.vertices()[vertex].point;
        for (const BoundaryCurve& b : boundary) {
            if (!b.box.contains(p)) continue;
            const double t = closest_from(b.trace, p, 0, 1);
            const Eigen::Vector3d closest = b.trace.point(t);
            const bool at_end = std::min((p - b.trace.point(0)).norm(), (p - b.trace.point(1)).norm()) <= 2 * distance;
            if (!at_end && (closest - p).norm() <= distance)
                result.push_back({vertex, b.curve, t, (closest - p).norm()});
        }
    }
    return result;
}

}  // namespace gradus
