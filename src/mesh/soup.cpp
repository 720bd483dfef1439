#include "gradus/mesh/soup.hpp"

#include <Eigen/Geometry>

namespace gradus {

double diagonal_of(const TriangleSoup& soup) {
    Eigen::AlignedBox3d box;
    for (const Triangle& t : soup.triangles)
        for (const int v : t) box.extend(soup.points[v]);
    return box.isEmpty() ? 0 : box.diagonal().norm();
}

}  // namespace gradus
