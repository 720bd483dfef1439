#include "gradus/surface/projection.hpp"

#include <algorithm>
#include <cmath>

namespace gradus {

namespace {

constexpr int kSteps = 30;
constexpr int kHalvings = 8;

}  // namespace

PatchProjection project(const ParametricSurface& surface, const Eigen::Vector3d& p, const Eigen::Vector2d& start, bool inside) {
    const Domain domain = surface.domain();
    const Eigen::Vector2d extent = domain.max - domain.min;
    Eigen::Vector2d uv = start;
    Jet1 jet = surface.jet1(uv);
    double distance = (p - jet.p).norm();
    for (int step = 0; step < kSteps; ++step) {
        const Eigen::Vector3d r = p - jet.p;
        const double a = jet.du.dot(r), b = jet.dv.dot(r);
        double E = jet.du.squaredNorm(), F = jet.du.dot(jet.dv), G = jet.dv.squaredNorm();
        // On a side of the domain that the step would cross, move along the side only; at a pole one direction stands still.
        const auto held = [&](int axis, double slope) {
            return inside && ((uv[axis] <= domain.min[axis] && slope < 0) || (uv[axis] >= domain.max[axis] && slope > 0));
        };
        const double trace = E + G;
        if (!(trace > 0)) break;
        E += 1e-15 * trace;
        G += 1e-15 * trace;
        Eigen::Vector2d d;
        const bool hold_u = held(0, a), hold_v = held(1, b);
        if (hold_u && hold_v) break;
        if (hold_u) d = {0, b / G};
        else if (hold_v) d = {a / E, 0};
        else {
            const double det = std::max(E * G - F * F, 1e-14 * E * G);
            d = {(G * a - F * b) / det, (E * b - F * a) / det};
        }
        for (int i = 0; i < 2; ++i) d[i] = std::clamp(d[i], -extent[i] / 4, extent[i] / 4);
        bool nearer = false;
        for (int halving = 0; halving < kHalvings && !nearer; ++halving, d /= 2) {
            Eigen::Vector2d trial = uv + d;
            if (inside) trial = trial.cwiseMax(domain.min).cwiseMin(domain.max);
            const Jet1 there = surface.jet1(trial);
            const double farther = (p - there.p).norm();
            if (farther < distance) {
                nearer = true;
                uv = trial;
                jet = there;
                distance = farther;
            }
        }
        if (!nearer) break;
    }
    return {uv, distance};
}

PatchProjection project(const ParametricSurface& surface, const Eigen::Vector3d& p, int cells) {
    const Domain domain = surface.domain();
    Eigen::Vector2d best = domain.min;
    double least = -1;
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) {
            const Eigen::Vector2d uv = domain.min + Eigen::Vector2d(i, j).cwiseProduct(domain.max - domain.min) / cells;
            const double d = (surface.position(uv) - p).squaredNorm();
            if (least < 0 || d < least) least = d, best = uv;
        }
    return project(surface, p, best, true);
}

}  // namespace gradus
