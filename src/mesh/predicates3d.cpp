#include "predicates3d.hpp"

#include "expansion.hpp"

namespace gradus::exact {
namespace {

int orient3d_exact(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d) {
    const Difference ax = difference(a.x(), d.x()), ay = difference(a.y(), d.y()), az = difference(a.z(), d.z());
    const Difference bx = difference(b.x(), d.x()), by = difference(b.y(), d.y()), bz = difference(b.z(), d.z());
    const Difference cx = difference(c.x(), d.x()), cy = difference(c.y(), d.y()), cz = difference(c.z(), d.z());
    Expansion<3 * 64> det;
    add_product(det, cross(bx, by, cx, cy), az);
    add_product(det, cross(cx, cy, ax, ay), bz);
    add_product(det, cross(ax, ay, bx, by), cz);
    return det.sign();
}

}  // namespace

int orient3d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
    const double ax = a.x() - d.x(), ay = a.y() - d.y(), az = a.z() - d.z();
    const double bx = b.x() - d.x(), by = b.y() - d.y(), bz = b.z() - d.z();
    const double cx = c.x() - d.x(), cy = c.y() - d.y(), cz = c.z() - d.z();
    const double bxcy = bx * cy, cxby = cx * by, cxay = cx * ay, axcy = ax * cy, axby = ax * by, bxay = bx * ay;
    const double det = az * (bxcy - cxby) + bz * (cxay - axcy) + cz * (axby - bxay);
    const double permanent = std::abs(az) * (std::abs(bxcy) + std::abs(cxby)) +
                             std::abs(bz) * (std::abs(cxay) + std::abs(axcy)) +
                             std::abs(cz) * (std::abs(axby) + std::abs(bxay));
    constexpr double kBound = 7.771561172376103e-16;  // (7 + 56 u) u, u = 2^-53 [Shewchuk 1997]
    if (det > kBound * permanent) return 1;
    if (det < -kBound * permanent) return -1;
    return permanent == 0 ? 0 : orient3d_exact(a, b, c, d);
}

int orient2d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int axis) {
    const int x = (axis + 1) % 3, y = (axis + 2) % 3;
    const double left = (a[x] - c[x]) * (b[y] - c[y]);
    const double right = (a[y] - c[y]) * (b[x] - c[x]);
    const double det = left - right;
    constexpr double kBound = 3.3306690738754716e-16;  // (3 + 16 u) u, u = 2^-53 [Shewchuk 1997]
    const double error = kBound * (std::abs(left) + std::abs(right));
    if (det > error) return 1;
    if (det < -error) return -1;
    return cross(difference(a[x], c[x]), difference(a[y], c[y]), difference(b[x], c[x]), difference(b[y], c[y])).sign();
}

}  // namespace gradus::exact
