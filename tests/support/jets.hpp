/// Derivatives by central differences, the oracle for jets.
#pragma once

#include <catch2/catch.hpp>

#include "gradus/surface/parametric_surface.hpp"

namespace gradus {

/// Checks a surface's position, jet1, jet2 and jets at uv against each other and against central differences of step h
/// in both parameters.
/// @param relative  error allowed in first and second derivatives, relative to the largest of them
inline void check_jets(const ParametricSurface& surface, const Eigen::Vector2d& uv, double h = 1e-4,
                       double relative = 1e-6) {
    const Jet2 jet = surface.jet2(uv);
    const Jet1 first = surface.jet1(uv);
    const Eigen::Vector2d a(h, 0), b(0, h);
    CHECK(surface.position(uv) == jet.p);
    CHECK(first.p == jet.p);
    CHECK((first.du - jet.du).norm() <= 1e-14 * jet.du.norm());
    CHECK((first.dv - jet.dv).norm() <= 1e-14 * jet.dv.norm());
    Jet2 batch;
    surface.jets(std::span(&uv, 1), std::span(&batch, 1));
    CHECK(batch.p == jet.p);
    CHECK(batch.dvv == jet.dvv);

    const Jet1 left = surface.jet1(uv - a), right = surface.jet1(uv + a), below = surface.jet1(uv - b),
               above = surface.jet1(uv + b);
    const double scale =
        jet.p.norm() + jet.du.norm() + jet.dv.norm() + jet.duu.norm() + jet.duv.norm() + jet.dvv.norm();
    const double allowed = relative * scale;
    CHECK(((right.p - left.p) / (2 * h) - jet.du).norm() <= allowed);
    CHECK(((above.p - below.p) / (2 * h) - jet.dv).norm() <= allowed);
    CHECK(((right.du - left.du) / (2 * h) - jet.duu).norm() <= allowed);
    CHECK(((right.dv - left.dv) / (2 * h) - jet.duv).norm() <= allowed);
    CHECK(((above.du - below.du) / (2 * h) - jet.duv).norm() <= allowed);
    CHECK(((above.dv - below.dv) / (2 * h) - jet.dvv).norm() <= allowed);
}

}  // namespace gradus
