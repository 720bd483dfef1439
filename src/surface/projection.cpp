#include "gradus/surface/projection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace gradus {

namespace {

constexpr int kSteps = 30;
constexpr int kHalvings = 8;

}  // namespace

PatchProjection project(const ParametricSurface& surface, const Eigen::Vector3d& p, const Eigen::Vector2d& start,
                        bool inside) {
    const Domain domain = surface.domain();
    const Eigen::Vector2d extent = domain.max - domain.min;
    Eigen::Vector2d uv = start;
    Jet1 jet = surface.jet1(uv);
    double distance = (p - jet.p).norm();
    for (int step = 0; step < kSteps; ++step) {
        const Eigen::Vector3d r = p - jet.p;
        const double a = jet.du.dot(r), b = jet.dv.dot(r);
        double E = jet.du.squaredNorm(), F = jet.du.dot(jet.dv), G = jet.dv.squaredNorm();
        // On a side of the domain that the step would cross, move along the side only; at a pole one direction stands
        // still.
        const auto held = [&](int axis, double slope) {
            return inside &&
                   ((uv[axis] <= domain.min[axis] && slope < 0) || (uv[axis] >= domain.max[axis] && slope > 0));
        };
        const double trace = E + G;
        if (!(trace > 0)) break;
        E += 1e-15 * trace;
        G += 1e-15 * trace;
        Eigen::Vector2d d;
        const bool hold_u = held(0, a), hold_v = held(1, b);
        if (hold_u && hold_v) break;
        if (hold_u)
            d = {0, b / G};
        else if (hold_v)
            d = {a / E, 0};
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
    const auto uv_of = [&](int i, int j) -> Eigen::Vector2d {
        return domain.min + Eigen::Vector2d(i, j).cwiseProduct(domain.max - domain.min) / cells;
    };
    std::vector<double> squared;
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) {
            squared.push_back((surface.position(uv_of(i, j)) - p).squaredNorm());
            least = std::min(least, squared.back());
            most = std::max(most, squared.back());
        }
    // On a seam the same point is a start from either side, and only one of them may lead inside.
    PatchProjection best{domain.min, std::numeric_limits<double>::infinity()};
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) {
            if (squared[j * (cells + 1) + i] > least + 1e-12 * most) continue;
            const PatchProjection found = project(surface, p, uv_of(i, j), true);
            if (found.distance < best.distance) best = found;
        }
    return best;
}

}  // namespace gradus
