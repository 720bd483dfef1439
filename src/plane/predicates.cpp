#include "gradus/plane/predicates.hpp"

#include "../mesh/expansion.hpp"

namespace gradus {
namespace {

using namespace exact;

Expansion<16> squared_length(const Difference& x, const Difference& y) {
    Expansion<16> result;
    add_product(result, x, x);
    add_product(result, y, y);
    result.compress();
    return result;
}

int incircle_exact(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                   const Eigen::Vector2d& d) {
    const Difference ax = difference(a.x(), d.x()), ay = difference(a.y(), d.y());
    const Difference bx = difference(b.x(), d.x()), by = difference(b.y(), d.y());
    const Difference cx = difference(c.x(), d.x()), cy = difference(c.y(), d.y());
    Expansion<3 * 512> det;
    add_product(det, squared_length(ax, ay), cross(bx, by, cx, cy));
    add_product(det, squared_length(bx, by), cross(cx, cy, ax, ay));
    add_product(det, squared_length(cx, cy), cross(ax, ay, bx, by));
    return det.sign();
}

}  // namespace

int detail::orient2d_exact(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    const Difference ax = difference(a.x(), c.x()), ay = difference(a.y(), c.y());
    const Difference bx = difference(b.x(), c.x()), by = difference(b.y(), c.y());
    return cross(ax, ay, bx, by).sign();
}

int incircle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
    const double ax = a.x() - d.x(), ay = a.y() - d.y();
    const double bx = b.x() - d.x(), by = b.y() - d.y();
    const double cx = c.x() - d.x(), cy = c.y() - d.y();
    const double bxcy = bx * cy, cxby = cx * by, cxay = cx * ay, axcy = ax * cy, axby = ax * by, bxay = bx * ay;
    const double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const double det = a2 * (bxcy - cxby) + b2 * (cxay - axcy) + c2 * (axby - bxay);
    const double permanent = a2 * (std::abs(bxcy) + std::abs(cxby)) + b2 * (std::abs(cxay) + std::abs(axcy)) +
                             c2 * (std::abs(axby) + std::abs(bxay));
    constexpr double kBound = 1.1102230246251577e-15;  // (10 + 96 u) u, u = 2^-53
    if (det > kBound * permanent) return 1;
    if (det < -kBound * permanent) return -1;
    return incircle_exact(a, b, c, d);
}

}  // namespace gradus
