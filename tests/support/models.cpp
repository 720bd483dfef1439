#include "support/models.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <utility>

namespace gradus::models {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double pi = 3.14159265358979323846;

using IndexMap = std::function<std::pair<int, int>(int, int)>;

/// Net of the given degrees whose point (i, j) is the old one at from(i, j).
BezierNet picked(const BezierNet& net, int degree_u, int degree_v, const IndexMap& from) {
    BezierNet result{degree_u, degree_v, {}, {}};
    for (int j = 0; j <= degree_v; ++j)
        for (int i = 0; i <= degree_u; ++i) {
            const auto [a, b] = from(i, j);
            const int k = b * (net.degree_u + 1) + a;
            result.points.push_back(net.points[k]);
            if (!net.weights.empty()) result.weights.push_back(net.weights[k]);
        }
    return result;
}

/// Net from homogeneous points (w x, w y, w z, w), i along u fastest.
BezierNet from_homogeneous(int m, int n, const std::vector<Vector4d>& points) {
    BezierNet net{m, n, {}, {}};
    for (const Vector4d& p : points) {
        net.points.push_back(p.head<3>() / p.w());
        net.weights.push_back(p.w());
    }
    return net;
}

BezierNet bilinear(const Vector3d& p00, const Vector3d& p10, const Vector3d& p01, const Vector3d& p11) {
    return {1, 1, {p00, p10, p01, p11}, {}};
}

/// Quarter k of the unit circle as a rational quadratic: point i of 3 and its weight. Coordinates are exactly 0, 1 or
/// -1.
struct ArcPoint {
    double x, y, w;
};
ArcPoint quarter_arc(int k, int i) {
    constexpr std::array<std::array<int, 2>, 8> ring{
        {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
    const std::array<int, 2> at = ring[(2 * k + i) % 8];
    return {static_cast<double>(at[0]), static_cast<double>(at[1]), i == 1 ? std::sqrt(0.5) : 1.0};
}

/// A quadratic profile (r, z, weight) turned by quarter k about the z axis: u around, v along the profile.
BezierNet turned_profile(int k, const std::vector<ArcPoint>& profile) {
    BezierNet net{2, static_cast<int>(profile.size()) - 1, {}, {}};
    for (const ArcPoint& p : profile)
        for (int i = 0; i < 3; ++i) {
            const ArcPoint arc = quarter_arc(k, i);
            net.points.emplace_back(p.x * arc.x, p.x * arc.y, p.y);
            net.weights.push_back(p.w * arc.w);
        }
    return net;
}

double binomial(int n, int k) {
    double result = 1;
    for (int i = 0; i < k; ++i) result = result * (n - i) / (i + 1);
    return result;
}

/// Bernstein coefficients of the product of two biquadratic polynomials, 5 x 5.
std::array<double, 25> product(const std::array<double, 9>& a, const std::array<double, 9>& b) {
    std::array<double, 25> c{};
    for (int i = 0; i < 9; ++i)
        for (int j = 0; j < 9; ++j) {
            const int x = i % 3 + j % 3, y = i / 3 + j / 3;
            c[5 * y + x] += a[i] * b[j] * binomial(2, i % 3) * binomial(2, j % 3) / binomial(4, x) *
                            binomial(2, i / 3) * binomial(2, j / 3) / binomial(4, y);
        }
    return c;
}

}  // namespace

SurfaceModel model_of(const Nets& nets, const ModelOptions& options) {
    return make_model(PatchFile{nets, {}}, options);
}

SurfaceModel model_of(Patch patch) {
    std::vector<Patch> patches;
    patches.push_back(std::move(patch));
    return glue(std::move(patches));
}

Nets mapped(Nets nets, const std::function<Vector3d(const Vector3d&)>& move) {
    for (BezierNet& net : nets)
        for (Vector3d& p : net.points) p = move(p);
    return nets;
}

Nets scaled(const Nets& nets, double factor) {
    return mapped(nets, [factor](const Vector3d& p) -> Vector3d { return factor * p; });
}

BezierNet flip_u(const BezierNet& net) {
    return picked(net, net.degree_u, net.degree_v, [&](int i, int j) { return std::pair(net.degree_u - i, j); });
}
BezierNet flip_v(const BezierNet& net) {
    return picked(net, net.degree_u, net.degree_v, [&](int i, int j) { return std::pair(i, net.degree_v - j); });
}
BezierNet swap_uv(const BezierNet& net) {
    return picked(net, net.degree_v, net.degree_u, [](int i, int j) { return std::pair(j, i); });
}

BezierNet raise_u(const BezierNet& net) {
    const int m = net.degree_u;
    BezierNet result{m + 1, net.degree_v, {}, {}};
    for (int j = 0; j <= net.degree_v; ++j)
        for (int i = 0; i <= m + 1; ++i) {
            const double t = static_cast<double>(i) / (m + 1);
            Vector3d p = Vector3d::Zero();
            if (i > 0) p += t * net.points[j * (m + 1) + i - 1];
            if (i <= m) p += (1 - t) * net.points[j * (m + 1) + i];
            result.points.push_back(p);
        }
    return result;
}

BezierNet turned(const BezierNet& net, int k) {
    BezierNet result = net;
    if (k & 1) result = flip_u(result);
    if (k & 2) result = flip_v(result);
    if (k & 4) result = swap_uv(result);
    return result;
}

Nets shuffled(const Nets& nets) {
    Nets result;
    // 3 and 8 have no common factor: all eight variants appear, neighbours differ.
    for (std::size_t i = 0; i < nets.size(); ++i) result.push_back(turned(nets[i], static_cast<int>((3 * i + 1) % 8)));
    return result;
}

Nets teapot_nets() { return read_patches(std::string(GRADUS_ASSETS) + "/teapot.bpt").nets; }
SurfaceModel teapot() { return model_of(teapot_nets()); }

BezierNet flat_square() { return bump(0); }

BezierNet bump(double height) {
    BezierNet net;
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) net.points.emplace_back(i / 3.0, j / 3.0, i % 3 != 0 && j % 3 != 0 ? height : 0.0);
    return net;
}

BezierNet uneven_square(double stretch) {
    BezierNet net = flat_square();
    for (int j = 0; j < 4; ++j) net.points[4 * j + 1].x() /= stretch;
    return net;
}

BezierNet sliver(double aspect, double length) {
    BezierNet net = flat_square();
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
            Vector3d& p = net.points[4 * j + i];
            p = Vector3d(length * p.x(), length / aspect * p.y(), i % 3 != 0 ? length / 15 : 0.0);
        }
    return net;
}

Nets wavy_sheet(int n, double amplitude) {
    const double h = 1.0 / n;
    const auto f = [](double x) { return std::sin(pi * x); };
    const auto df = [](double x) { return pi * std::cos(pi * x); };
    // Bernstein coefficients on [x0, x0 + h] of the cubic with the values and slopes of f at both ends. The graph is a
    // product of two such splines: C1.
    const auto cubic = [&](int cell, int i) {
        const double x0 = cell * h, x1 = (cell + 1) * h;
        return i == 0 ? f(x0) : i == 1 ? f(x0) + h / 3 * df(x0) : i == 2 ? f(x1) - h / 3 * df(x1) : f(x1);
    };
    Nets nets;
    for (int b = 0; b < n; ++b)
        for (int a = 0; a < n; ++a) {
            BezierNet net;
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i)
                    net.points.emplace_back((3 * a + i) / (3.0 * n), (3 * b + j) / (3.0 * n),
                                            amplitude * cubic(a, i) * cubic(b, j));
            nets.push_back(std::move(net));
        }
    return nets;
}

Nets hinge(double angle) {
    const Vector3d left(-1, 0, 0), right(std::cos(angle), 0, std::sin(angle)), y = Vector3d::UnitY(),
                                                                               o = Vector3d::Zero();
    return {bilinear(left, o, left + y, y), bilinear(o, right, y, right + y)};
}

Nets mixed_degrees() {
    BezierNet right = bump(0.3);
    for (int j = 1; j < 3; ++j) right.points[4 * j].z() = 0.2;  // the shared cubic is not straight
    // The left patch: u along the shared cubic, v away from it, linear.
    BezierNet left{3, 1, {}, {}};
    for (int i = 0; i < 4; ++i) left.points.push_back(right.points[4 * i]);
    for (int i = 0; i < 4; ++i) left.points.emplace_back(-1, i / 3.0, 0);
    return {right, raise_u(raise_u(left))};
}

Nets differing_parameters() {
    BezierNet left = flat_square();
    for (Vector3d& p : left.points) p.x() -= 1;
    BezierNet right = flat_square();
    for (int i = 0; i < 4; ++i) {
        right.points[4 + i].y() = 0.05;
        right.points[8 + i].y() = 0.4;
    }
    return {left, right};
}

Nets cube() {
    Nets nets;
    for (int axis = 0; axis < 3; ++axis)
        for (int end = 0; end < 2; ++end) {
            Vector3d o = Vector3d::Zero(), a = Vector3d::Zero(), b = Vector3d::Zero();
            o[axis] = end;
            a[(axis + 1) % 3] = 1;
            b[(axis + 2) % 3] = 1;
            nets.push_back(bilinear(o, o + a, o + b, o + a + b));
        }
    return nets;
}

Nets cushion(double height) { return {bump(height), bump(-height)}; }

Nets sphere_octants(double radius) {
    Nets nets;
    for (int half = -1; half <= 0; ++half)
        for (int k = 0; k < 4; ++k) {
            std::vector<ArcPoint>
                meridian;  // quarter -1 runs from the south pole to the equator, quarter 0 on to the north pole
            for (int j = 0; j < 3; ++j) {
                const ArcPoint p = quarter_arc(half + 4, j);
                meridian.push_back({radius * p.x, radius * p.y, p.w});
            }
            nets.push_back(turned_profile(k, meridian));
        }
    return nets;
}

Nets sphere_cube(double radius) {
    // The face around +z, projected from the south pole to the plane, is bounded by four arcs of circles of radius
    // sqrt(2) around
    // (-1, 0) and so on, of half angle 15 degrees. A biquadratic (X, Y, W) with these arcs as sides, put into the
    // inverse projection (2 X W, 2 Y W, W^2 - X^2 - Y^2) / (X^2 + Y^2 + W^2), is a patch of degree 4.
    const double a = 1 / (1 + std::sqrt(3.0)), cosine = std::cos(pi / 12),
                 b = std::sqrt(2.0) - cosine;  // b: tangents meet, times the weight
    const std::array<double, 9> X{-a, 0, a, -b, 0, b, -a, 0, a}, Y{-a, -b, -a, 0, 0, 0, a, b, a};
    const std::array<double, 9> W{1, cosine, 1, cosine, cosine * cosine, cosine, 1, cosine, 1};
    const std::array<double, 25> XX = product(X, X), YY = product(Y, Y), WW = product(W, W), XW = product(X, W),
                                 YW = product(Y, W);
    std::vector<Vector4d> face;
    for (int k = 0; k < 25; ++k)
        face.emplace_back(radius * 2 * XW[k], radius * 2 * YW[k], radius * (WW[k] - XX[k] - YY[k]),
                          XX[k] + YY[k] + WW[k]);
    const BezierNet top = from_homogeneous(4, 4, face);
    const auto map = [&](const std::function<Vector3d(const Vector3d&)>& move) { return mapped({top}, move)[0]; };
    return {top,
            map([](const Vector3d& p) { return Vector3d(p.x(), -p.y(), -p.z()); }),
            map([](const Vector3d& p) { return Vector3d(p.z(), p.x(), p.y()); }),
            map([](const Vector3d& p) { return Vector3d(-p.z(), -p.x(), p.y()); }),
            map([](const Vector3d& p) { return Vector3d(p.y(), p.z(), p.x()); }),
            map([](const Vector3d& p) { return Vector3d(p.y(), -p.z(), -p.x()); })};
}

Nets torus(double major, double minor) {
    Nets nets;
    for (int q = 0; q < 4; ++q)
        for (int k = 0; k < 4; ++k) {
            std::vector<ArcPoint> tube;
            for (int j = 0; j < 3; ++j) {
                const ArcPoint p = quarter_arc(q, j);
                tube.push_back({major + minor * p.x, minor * p.y, p.w});
            }
            nets.push_back(turned_profile(k, tube));
        }
    return nets;
}

Nets cylinder(double radius, double height) {
    Nets nets;
    for (int k = 0; k < 4; ++k) nets.push_back(turned_profile(k, {{radius, 0, 1}, {radius, height, 1}}));
    return nets;
}

Nets cone(double radius, double height) {
    Nets nets;
    for (int k = 0; k < 4; ++k) nets.push_back(turned_profile(k, {{radius, 0, 1}, {0, height, 1}}));
    return nets;
}

SurfaceModel two_hemispheres(double radius) {
    std::vector<Patch> patches;
    for (int k = 0; k < 2; ++k)
        patches.push_back(reparametrise(make_sphere(Vector3d::Zero(), radius), Eigen::Matrix2d::Identity(),
                                        Vector2d::Zero(), {{k * pi, -pi / 2}, {(k + 1) * pi, pi / 2}}));
    return glue(std::move(patches));
}

SurfaceModel sphere_with_seam(double radius) { return model_of(make_sphere(Vector3d::Zero(), radius)); }
SurfaceModel torus_with_seams(double major, double minor) {
    return model_of(make_torus(Vector3d::Zero(), major, minor));
}
SurfaceModel cylinder_with_seam(double radius, double height) {
    return model_of(make_cylinder(Vector3d::Zero(), radius, height));
}

Patch stretched_sphere(double stretch, double radius) {
    Eigen::Matrix2d A;
    A << stretch, 0, 0, 1;
    return reparametrise(make_sphere(Vector3d::Zero(), radius), A, Vector2d::Zero(),
                         {{0, -pi / 2}, {2 * pi / stretch, pi / 2}});
}

}  // namespace gradus::models
