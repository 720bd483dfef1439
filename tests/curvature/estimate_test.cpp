// Curvature of triangulations against surfaces that have it in closed form.
#include "gradus/curvature/estimate.hpp"

#include <tbb/global_control.h>

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include "gradus/curvature/principal.hpp"
#include "gradus/surface/smooth_support.hpp"
#include "support/models.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;
using testing::Mesh;

namespace {

struct Estimated {
    Connectivity mesh;
    Features features;
    Wedges wedges;
    std::vector<WedgeCurvature> curvature;
};

Estimated estimated(const Mesh& mesh, const EstimateOptions& options = {}) {
    Estimated e{Connectivity(static_cast<int>(mesh.points.size()), mesh.triangles), {}, {}, {}};
    e.features = find_features(mesh.points, e.mesh);
    e.wedges = wedges_of(e.mesh);
    e.curvature =
        estimate_curvature(mesh.points, e.mesh, e.wedges, wedge_normals(mesh.points, e.mesh, e.wedges), options);
    return e;
}

// Largest error of k1 over the vertices.
template <class Exact>
double largest_error(const Mesh& mesh, const Exact& exact) {
    const Estimated e = estimated(mesh);
    double largest = 0;
    for (int w = 0; w < e.wedges.size(); ++w)
        largest = std::max(largest, std::abs(e.curvature[w].k1 - exact(mesh.points[e.wedges.vertex[w]])));
    return largest;
}

// Principal curvature of largest size of F = x^2/a^2 + y^2/b^2 + z^2/c^2 = 1.
double ellipsoid_k1(const Vector3d& axes, const Vector3d& p) {
    const Vector3d weights = axes.cwiseProduct(axes).cwiseInverse(), gradient = 2 * weights.cwiseProduct(p),
                   n = gradient.normalized();
    const Eigen::Matrix3d hessian = (2 * weights).asDiagonal(), flat = Eigen::Matrix3d::Identity() - n * n.transpose();
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(flat * hessian * flat / gradient.norm())
        .eigenvalues()
        .maxCoeff();
}

Mesh ellipsoid(int halvings, const Vector3d& axes) {
    Mesh mesh = triangulations::sphere(halvings);
    for (Vector3d& p : mesh.points) p = axes.cwiseProduct(p);
    return mesh;
}

std::vector<double> radius_errors(const Mesh& mesh, double radius) {
    std::vector<double> errors;
    for (const WedgeCurvature& c : estimated(mesh).curvature)
        errors.push_back(std::abs(1 / std::abs(c.k1) / radius - 1));
    std::sort(errors.begin(), errors.end());
    return errors;
}

double quantile(const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * double(sorted.size() - 1))];
}

}  // namespace

TEST_CASE("curvature of spheres, ellipsoids and tori converges with the square of the edges at least", "[converges]") {
    // The irregular mesh is halved itself, so that the ratio of errors is not one of luck.
    SECTION("sphere") {
        // Coarse as they are, of 66 and 258 vertices: fits are exact for spheres but for how well their curvature is
        // known beforehand.
        const auto exact = [](const Vector3d&) { return 0.5; };
        CHECK(largest_error(triangulations::sphere(3, 2), exact) < 1e-3);
        CHECK(largest_error(triangulations::sphere(4, 2), exact) < 2e-5);
    }
    SECTION("ellipsoid") {
        const Vector3d axes(1, 1.3, 0.8);
        const auto exact = [&](const Vector3d& p) { return ellipsoid_k1(axes, p); };
        const double a = largest_error(ellipsoid(4, axes), exact), b = largest_error(ellipsoid(5, axes), exact),
                     c = largest_error(ellipsoid(6, axes), exact);
        CAPTURE(a, b, c);
        CHECK(a / c > 9);
        CHECK(c < 0.01);
    }
    SECTION("torus") {
        const auto known = triangulations::torus_known(3, 1);
        const auto exact = [](const Vector3d&) { return 1.0; };
        const Mesh coarse = triangulations::torus(80, 28);
        const double a = largest_error(coarse, exact), b = largest_error(triangulations::halved(coarse, known), exact);
        CAPTURE(a, b);
        CHECK(a / b > 3.2);
    }
}

TEST_CASE("without noise the errors of nearly all vertices fall with about the third power of the edges",
          "[converges]") {
    const Mesh coarse = triangulations::torus(80, 28);
    const std::vector<double> a = radius_errors(coarse, 1),
                              b = radius_errors(triangulations::halved(coarse, triangulations::torus_known(3, 1)), 1);
    for (const double share : {0.5, 0.9}) {
        CAPTURE(share, quantile(a, share), quantile(b, share));
        CHECK(quantile(a, share) / quantile(b, share) > 6);
    }
}

TEST_CASE("a saddle has two curvatures of different signs, a cylinder one", "[converges]") {
    const auto inside = [](const Vector3d& p) { return p.x() > 0.2 && p.x() < 0.8 && p.y() > 0.2 && p.y() < 0.8; };
    SECTION("saddle") {
        // At (x, y) of z = x y: F = 0, E = 1 + y^2, G = 1 + x^2, M = 1 / sqrt(1 + x^2 + y^2).
        const Mesh mesh = triangulations::graph(40, [](double x, double y) { return (x - 0.5) * (y - 0.5); });
        const Estimated e = estimated(mesh);
        for (int w = 0; w < e.wedges.size(); ++w) {
            const Vector3d& p = mesh.points[e.wedges.vertex[w]];
            if (!inside(p)) continue;
            const double x = p.x() - 0.5, y = p.y() - 0.5, E = 1 + y * y, F = x * y, G = 1 + x * x,
                         s = 1 + x * x + y * y;
            const double M = 1 / std::sqrt(s), H = -2 * F * M / (2 * (E * G - F * F)), K = -1 / (s * s),
                         root = std::sqrt(H * H - K);
            const WedgeCurvature& c = e.curvature[w];
            CHECK(c.k1 * c.k2 == Approx(K).epsilon(0.01));
            CHECK(std::abs(c.k1) == Approx(std::abs(H) + root).epsilon(0.01));
            CHECK(std::abs(c.k1) >= std::abs(c.k2));
        }
    }
    SECTION("cylinder") {
        const double sign = GENERATE(1.0, -1.0);
        const Mesh mesh =
            triangulations::graph(40, [&](double x, double) { return sign * std::sqrt(4 - (x - 0.5) * (x - 0.5)); });
        const Estimated e = estimated(mesh);
        for (int w = 0; w < e.wedges.size(); ++w) {
            if (!inside(mesh.points[e.wedges.vertex[w]])) continue;
            // The normal is up: a hill bends to the inside.
            CHECK(e.curvature[w].k1 == Approx(sign / 2).epsilon(0.01));
            CHECK(std::abs(e.curvature[w].k2) < 0.01);
            CHECK(e.curvature[w].normal.z() > 0.9);
        }
    }
}

TEST_CASE("curvature changes its sign with the orientation and scales as one over length", "[property]") {
    const Mesh mesh = triangulations::sphere(4);
    Mesh inside = mesh, large = mesh;
    for (Triangle& t : inside.triangles) std::swap(t[1], t[2]);
    for (Vector3d& p : large.points) p *= 1e3;
    const auto a = estimated(mesh).curvature, b = estimated(inside).curvature, c = estimated(large).curvature;
    for (std::size_t w = 0; w < a.size(); ++w) {
        CHECK(a[w].k1 > 0);
        CHECK(a[w].k2 > 0);
        CHECK(a[w].normal.dot(mesh.points[w]) > 0.999);
        CHECK(b[w].k1 == Approx(-a[w].k1).epsilon(1e-6));
        CHECK(1e3 * c[w].k1 == Approx(a[w].k1).epsilon(1e-6));
    }
}

TEST_CASE("radii of a torus of 10000 irregular vertices are right, also under noise", "[property]") {
    const Mesh mesh = triangulations::torus(170, 60);
    REQUIRE(mesh.points.size() > 9000);
    const std::vector<double> clean = radius_errors(mesh, 1);
    CAPTURE(quantile(clean, 0.5), quantile(clean, 0.95), clean.back());
    CHECK(quantile(clean, 0.5) < 0.001);
    CHECK(quantile(clean, 0.95) < 0.005);
    const std::vector<double> noisy =
        radius_errors(triangulations::noisy(mesh, 0.01 * triangulations::mean_edge(mesh)), 1);
    CAPTURE(quantile(noisy, 0.5), quantile(noisy, 0.95), noisy.back());
    CHECK(quantile(noisy, 0.5) < 0.05);
    CHECK(quantile(noisy, 0.95) < 0.12);
    CHECK(quantile(noisy, 0.5) > quantile(clean, 0.5));
}

TEST_CASE("radii of a sampled teapot converge to those of its patches", "[converges]") {
    const SurfaceModel model = models::teapot();
    const auto errors = [&](int n) {
        std::vector<double> result;
        for (int p = 0; p < model.num_patches(); ++p) {
            const triangulations::Sampled sampled = triangulations::sampled(model.patch(p), n);
            const Estimated e = estimated(sampled.mesh);
            for (int v = 0; v < static_cast<int>(sampled.uv.size()); ++v)
                if (sampled.is_inner(v))
                    result.push_back(
                        std::abs(1 / std::abs(e.curvature[v].k1) / minimal_radius(model.patch(p), sampled.uv[v]) - 1));
        }
        std::sort(result.begin(), result.end());
        return result;
    };
    struct Bound {
        int n;
        double median, most;
    };
    for (const auto& [n, median, most] : {Bound{12, 0.025, 0.3}, Bound{24, 0.002, 0.05}, Bound{48, 0.0002, 0.005}}) {
        const std::vector<double> e = errors(n);
        CAPTURE(n, quantile(e, 0.5), quantile(e, 0.95), e.back());
        CHECK(quantile(e, 0.5) < median);
        CHECK(quantile(e, 0.95) < most);
    }
}

TEST_CASE("curvature at the rim of a cylinder is that of each side: round and flat", "[property]") {
    const double radius = 0.5;
    const Mesh mesh = triangulations::capped_cylinder(64, 40, radius, 2, 8);
    const Estimated e = estimated(mesh);
    REQUIRE(e.features.chains.size() == 2);
    REQUIRE(e.wedges.size() == static_cast<int>(mesh.points.size()) + 2 * 64);
    int caps = 0, sides = 0;
    for (int w = 0; w < e.wedges.size(); ++w) {
        const WedgeCurvature& c = e.curvature[w];
        if (std::abs(c.normal.z()) > 0.5) {
            ++caps;
            CHECK(std::abs(c.k1) < 1e-6);
            CHECK(std::abs(c.normal.z()) == Approx(1));
        } else {
            ++sides;
            CHECK(c.k1 == Approx(1 / radius).epsilon(0.02));
            CHECK(std::abs(c.k2) < 0.05 / radius);
            CHECK(std::abs(c.normal.z()) < 0.01);
        }
    }
    CHECK(caps == 2 * (8 * 64 + 1));
    CHECK(sides == 41 * 64);
}

TEST_CASE("coarse cylinders and cones of one row of facets have about the curvature of what they stand for",
          "[property]") {
    const int sides = GENERATE(8, 10, 14, 24);
    const double top = GENERATE(1.0, 0.5, 0.0), height = GENERATE(2.0, 20.0);
    CAPTURE(sides, top, height);
    Mesh mesh;
    for (int i = 0; i < sides; ++i) {
        const double a = 2 * std::numbers::pi * i / sides;
        mesh.points.push_back({std::cos(a), std::sin(a), 0});
    }
    const int ring = top > 0 ? sides : 1;
    for (int i = 0; i < ring; ++i)
        mesh.points.push_back(top > 0 ? Vector3d(top * mesh.points[i].x(), top * mesh.points[i].y(), height)
                                      : Vector3d(0, 0, height));
    for (int i = 0; i < sides; ++i) {
        const int j = (i + 1) % sides;
        mesh.triangles.push_back({i, j, sides + j % ring});
        if (top > 0) mesh.triangles.push_back({i, sides + j, sides + i});
    }
    const Estimated e = estimated(mesh);
    const double slope = std::atan2(1 - top, height);
    for (int w = 0; w < e.wedges.size(); ++w) {
        const Vector3d& p = mesh.points[e.wedges.vertex[w]];
        const double r = std::hypot(p.x(), p.y());
        if (r == 0) continue;  // the point of a cone
        const Vector3d normal(std::cos(slope) * p.x() / r, std::cos(slope) * p.y() / r, std::sin(slope));
        // Of a frustum both ends are fitted together.
        CHECK(e.curvature[w].k1 * r / std::cos(slope) == Approx(1).epsilon(top == 0.5 ? 0.6 : sides < 14 ? 0.4 : 0.15));
        CHECK(e.curvature[w].normal.dot(normal) > std::cos(0.06));
    }
}

TEST_CASE("noise asks for more rings, and precision that is not needed for none", "[property]") {
    const Mesh mesh = triangulations::sphere(4);
    const auto rings = [](const std::vector<WedgeCurvature>& curvature) {
        double sum = 0;
        for (const WedgeCurvature& c : curvature) sum += c.rings;
        return sum / double(curvature.size());
    };
    const Mesh noisy = triangulations::noisy(mesh, 0.02 * triangulations::mean_edge(mesh));
    CHECK(rings(estimated(mesh).curvature) == Approx(2).epsilon(0.01));
    CHECK(rings(estimated(noisy).curvature) > 2.5);
    // But for the six vertices of four edges.
    CHECK(rings(estimated(noisy, {.least_curvature = 1e3}).curvature) == Approx(2 + 6.0 / double(mesh.points.size())));
}

TEST_CASE("curvature is the same to the last bit for one and two threads", "[property]") {
    const Mesh mesh = triangulations::noisy(triangulations::torus(40, 16), 0.003);
    const auto with = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return estimated(mesh).curvature;
    };
    const auto one = with(1), two = with(2);
    REQUIRE(one.size() == two.size());
    for (std::size_t w = 0; w < one.size(); ++w)
        CHECK((one[w].k1 == two[w].k1 && one[w].k2 == two[w].k2 && one[w].normal == two[w].normal &&
               one[w].error == two[w].error && one[w].rings == two[w].rings));
}
