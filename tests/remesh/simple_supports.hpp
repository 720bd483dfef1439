/// Supports in closed form and meshes over them, for operations one by one.
#pragma once

#include <functional>
#include <numbers>

#include "../../src/remesh/editor.hpp"
#include "gradus/quality/topology.hpp"
#include "support/triangulations.hpp"

namespace gradus::testing {

/// A curve with its parameter in [0, 1], and how to find it.
struct SimpleCurve {
    std::function<Eigen::Vector3d(double)> at;
    std::function<double(const Eigen::Vector3d&)> parameter;
    bool closed = false;
};

inline SimpleCurve segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return {[=](double t) { return Eigen::Vector3d(a + t * (b - a)); },
            [=](const Eigen::Vector3d& p) { return (p - a).dot(b - a) / (b - a).squaredNorm(); }};
}

/// Around the z axis.
inline SimpleCurve circle(double radius) {
    using std::numbers::pi;
    return {[=](double t) { return Eigen::Vector3d(radius * std::cos(2 * pi * t), radius * std::sin(2 * pi * t), 0); },
            [](const Eigen::Vector3d& p) {
                const double t = std::atan2(p.y(), p.x()) / (2 * pi);
                return t < 0 ? t + 1 : t;
            },
            true};
}

/// A surface that knows its closest points, with curves on it, each a chain of its own.
class SimpleSupport : public Support, public MetricField<Size> {
  public:
    std::function<Eigen::Vector3d(const Eigen::Vector3d&)> project = [](const Eigen::Vector3d& p) {
        return Eigen::Vector3d(p.x(), p.y(), 0);
    };
    std::function<Eigen::Vector3d(const Eigen::Vector3d&)> normal = [](const Eigen::Vector3d&) {
        return Eigen::Vector3d(0, 0, 1);
    };
    std::function<double(const Eigen::Vector3d&)> wanted = [](const Eigen::Vector3d&) { return 1.0; };
    std::vector<SimpleCurve> curves = {};

    Foot foot(Place place, const Eigen::Vector3d& target) const {
        const Eigen::Vector3d p = place.curve >= 0 ? curves[place.curve].at(place.t) : project(target);
        return {place, p, normal(p)};
    }
    double size(const Eigen::Vector3d& p, int&) const override { return wanted(p); }
    Foot on_curve(int curve, double t) const {
        Place place;
        place.curve = curve;
        place.t = curves[curve].closed ? t - std::floor(t) : t;
        return foot(place, {});
    }
    std::optional<Foot> move(const Place& from, const Eigen::Vector3d&, const Eigen::Vector3d& target) const override {
        return foot(from, target);
    }
    std::optional<Foot> slide(const Place& from, const Eigen::Vector3d& target) const override {
        const double t = curves[from.curve].parameter(target);
        if (!curves[from.curve].closed && !(t > 0 && t < 1)) return std::nullopt;
        return on_curve(from.curve, t);
    }
    int chain_of(int curve) const override { return curve; }
    Foot middle(int chain, const Foot& a, const Foot& b) const override {
        const double ta = curves[chain].parameter(a.point);
        double tb = curves[chain].parameter(b.point);
        if (curves[chain].closed) tb -= std::round(tb - ta);
        return on_curve(chain, (ta + tb) / 2);
    }
};

inline SimpleSupport plane(double h = 1) {
    SimpleSupport support;
    support.wanted = [h](const Eigen::Vector3d&) { return h; };
    return support;
}

inline SimpleSupport ball(double radius, double h) {
    SimpleSupport support = plane(h);
    support.project = [radius](const Eigen::Vector3d& p) { return Eigen::Vector3d(radius * p.normalized()); };
    support.normal = [](const Eigen::Vector3d& p) { return Eigen::Vector3d(p.normalized()); };
    return support;
}

/// The unit square with its four sides as curves 0 to 3.
inline SimpleSupport square_support(double h) {
    SimpleSupport support = plane(h);
    const Eigen::Vector3d corner[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (int k = 0; k < 4; ++k) support.curves.push_back(segment(corner[k], corner[(k + 1) % 4]));
    return support;
}

/// A vertex of a surface inside, or on a curve.
inline Vertex vertex_at(const SimpleSupport& support, const Eigen::Vector3d& p) {
    Vertex v;
    stand(v, support.foot({}, p), support, support);
    return v;
}
inline Vertex vertex_on(const SimpleSupport& support, int curve, const Eigen::Vector3d& p) {
    Vertex v;
    stand(v, support.on_curve(curve, support.curves[curve].parameter(p)), support, support);
    v.bound = Bound::Curve;
    return v;
}

/// Everything free.
inline Editor editor_of(const SimpleSupport& support, const Mesh& mesh) {
    std::vector<Vertex> vertices;
    for (const Eigen::Vector3d& p : mesh.points) vertices.push_back(vertex_at(support, p));
    return {support, support, std::move(vertices), Connectivity(static_cast<int>(mesh.points.size()), mesh.triangles)};
}

/// A mesh whose edges along curves have tags, and whose vertices slide on the one curve they lie on, or are fixed where
/// they lie on two or are an end of one.
inline Editor editor_with_curves(const SimpleSupport& support, const Mesh& mesh) {
    constexpr double kOn = 1e-12;
    const auto on = [&](int curve, const Eigen::Vector3d& p) {
        const SimpleCurve& c = support.curves[curve];
        const double t = c.parameter(p);
        return t >= -kOn && t <= 1 + kOn && (c.at(t) - p).norm() < kOn;
    };
    const auto ends = [&](int curve, const Eigen::Vector3d& p) {
        const SimpleCurve& c = support.curves[curve];
        return !c.closed && ((c.at(0) - p).norm() < kOn || (c.at(1) - p).norm() < kOn);
    };
    std::vector<Vertex> vertices;
    for (const Eigen::Vector3d& p : mesh.points) {
        std::vector<int> curves;
        bool is_end = false;
        for (int c = 0; c < static_cast<int>(support.curves.size()); ++c)
            if (on(c, p)) curves.push_back(c), is_end = is_end || ends(c, p);
        if (curves.size() == 1 && !is_end) {
            vertices.push_back(vertex_on(support, curves[0], p));
            continue;
        }
        vertices.push_back(vertex_at(support, p));
        if (!curves.empty()) vertices.back().bound = Bound::Fixed;
    }
    Connectivity connectivity(static_cast<int>(mesh.points.size()), mesh.triangles);
    for (int h = 0; h < 3 * connectivity.num_triangles(); ++h) {
        const Eigen::Vector3d &a = mesh.points[connectivity.origin(h)], &b = mesh.points[connectivity.target(h)];
        for (int c = 0; c < static_cast<int>(support.curves.size()); ++c) {
            // On a closed curve chords are edges of it where no triangle is beyond them.
            const bool along = support.curves[c].closed ? connectivity.twin(h) < 0 : on(c, (a + b) / 2);
            if (on(c, a) && on(c, b) && along) connectivity.set_tag(h, c);
        }
    }
    return {support, support, std::move(vertices), std::move(connectivity)};
}

/// The live triangles with their points.
inline Mesh mesh_of(const Editor& editor) {
    Mesh mesh;
    for (const Vertex& v : editor.vertices()) mesh.points.push_back(v.p);
    for (int t = 0; t < editor.mesh().num_triangles(); ++t)
        if (editor.mesh().is_live_triangle(t)) mesh.triangles.push_back(editor.mesh().triangle(t));
    return mesh;
}

inline TopologyReport topology_of(const Editor& editor) {
    const Mesh mesh = mesh_of(editor);
    return measure_topology(mesh.view(), edges_of(mesh.view()));
}

/// Cosine between a triangle and the surface at its corners, where that is least.
inline double least_facing(const Editor& editor) {
    double least = 1;
    for (int t = 0; t < editor.mesh().num_triangles(); ++t) {
        if (!editor.mesh().is_live_triangle(t)) continue;
        const Triangle v = editor.mesh().triangle(t);
        const Vertex &a = editor.vertex(v[0]), &b = editor.vertex(v[1]), &c = editor.vertex(v[2]);
        least = std::min(least, least_agreement(a, b, c, (b.p - a.p).cross(c.p - a.p).normalized()));
    }
    return least;
}

}  // namespace gradus::testing
