// The smooth surface over triangulations of spheres and tori with exact normals, and walks on triangulations.
#include "gradus/surface/smooth_support.hpp"

#include <catch2/catch.hpp>

#include "gradus/control/triangulation.hpp"
#include "gradus/mesh/closest.hpp"
#include "gradus/surface/locate.hpp"
#include "support/models.hpp"
#include "support/triangulations.hpp"

using namespace gradus;
using Eigen::Vector3d;
using testing::Mesh;

namespace {

struct Smooth {
    Mesh triangles;
    Connectivity mesh;
    Features features;
    Wedges wedges;
    FlatFaces flats;
    std::unique_ptr<SmoothSupport> support;

    Smooth(const Mesh& given, const std::function<Vector3d(const Vector3d&)>& normal,
           const SmoothSupport::Options& options = {})
        : triangles(given), mesh(static_cast<int>(given.points.size()), given.triangles) {
        features = find_features(triangles.points, mesh);
        wedges = wedges_of(mesh);
        std::vector<Vector3d> normals = wedge_normals(triangles.points, mesh, wedges);
        if (normal)
            for (int w = 0; w < wedges.size(); ++w) normals[w] = normal(triangles.points[wedges.vertex[w]]);
        support = std::make_unique<SmoothSupport>(triangles.points, mesh, features, wedges, flats, std::move(normals),
                                                  options);
    }
    int size() const { return mesh.num_triangles(); }
};

// Point of the side from corner k, s along it.
Vector3d on_side(const GregoryPatch& patch, int k, double s) {
    std::array<double, 3> w{0, 0, 0};
    w[k] = 1 - s, w[(k + 1) % 3] = s;
    return patch.point(w[1], w[2]);
}

// Normal at it by differences, a step to the inside.
Vector3d side_normal(const GregoryPatch& patch, int k, double s) {
    constexpr double step = 1e-5;
    const auto at = [&](double along, double in) {
        std::array<double, 3> w{0, 0, 0};
        w[k] = 1 - along - in / 2, w[(k + 1) % 3] = along - in / 2, w[(k + 2) % 3] = in;
        return patch.point(w[1], w[2]);
    };
    const Vector3d along = at(s + step, 0) - at(s - step, 0), in = -3 * at(s, 0) + 4 * at(s, step) - at(s, 2 * step);
    return along.cross(in).normalized();
}

template <class Use>
void for_each_sample(const Smooth& smooth, int n, const Use& use) {
    for (int t = 0; t < smooth.size(); ++t) {
        const GregoryPatch patch = smooth.support->patch(t);
        for (int i = 0; i <= n; ++i)
            for (int j = 0; i + j <= n; ++j) use(t, patch, double(i) / n, double(j) / n);
    }
}

Vector3d flat_point(const Smooth& smooth, int t, double b, double c) {
    const Triangle& v = smooth.triangles.triangles[t];
    const auto& p = smooth.triangles.points;
    return (1 - b - c) * p[v[0]] + b * p[v[1]] + c * p[v[2]];
}

struct Errors {
    double smooth = 0, flat = 0;
};

Errors errors(const Smooth& s, const triangulations::Known& known) {
    Errors e;
    for_each_sample(s, 6, [&](int t, const GregoryPatch& patch, double b, double c) {
        const Vector3d p = patch.point(b, c), q = flat_point(s, t, b, c);
        e.smooth = std::max(e.smooth, (p - known.project(p)).norm());
        e.flat = std::max(e.flat, (q - known.project(q)).norm());
    });
    return e;
}

struct Case {
    const char* name;
    triangulations::Known known;
    Mesh mesh;
};

Case case_of(int k) {
    if (k == 0) return {"sphere", triangulations::sphere_known(1), triangulations::sphere(3)};
    return {"torus", triangulations::torus_known(3, 1), triangulations::torus(46, 18)};
}

}  // namespace

TEST_CASE("the smooth surface goes through the vertices, and both triangles of an edge have the same curve",
          "[exact]") {
    const Case c = case_of(GENERATE(0, 1));
    CAPTURE(c.name);
    const Smooth s(c.mesh, c.known.normal);
    double off = 0, gap = 0, off_curve = 0;
    for (int t = 0; t < s.size(); ++t) {
        const GregoryPatch patch = s.support->patch(t);
        for (int k = 0; k < 3; ++k) {
            const int h = 3 * t + k, g = s.mesh.twin(h);
            off = std::max(off, (on_side(patch, k, 0) - c.mesh.points[s.mesh.origin(h)]).norm());
            for (const double x : {0.1, 0.3, 0.5, 0.8}) {
                gap = std::max(gap, (on_side(patch, k, x) - on_side(s.support->patch(g / 3), g % 3, 1 - x)).norm());
                off_curve = std::max(off_curve, (on_side(patch, k, x) - s.support->curve_point(h, x)).norm());
            }
        }
    }
    CHECK(off == 0);
    CHECK(gap < 1e-14 * 5);
    CHECK(off_curve < 1e-14 * 5);
}

TEST_CASE("halving the edges lowers the error of the smooth surface with their fourth power", "[converges]") {
    Case c = case_of(GENERATE(0, 1));
    CAPTURE(c.name);
    const Mesh fine = triangulations::halved(c.mesh, c.known);
    const Errors a = errors(Smooth(c.mesh, c.known.normal), c.known), b = errors(Smooth(fine, c.known.normal), c.known);
    CAPTURE(a.smooth, b.smooth, a.flat, b.flat, fine.points.size());
    CHECK(a.smooth / b.smooth > 10);
    CHECK(a.flat / b.flat < 5);
}

TEST_CASE("at 5000 vertices the smooth surface is a hundred times nearer than the facets", "[converges]") {
    const bool sphere = GENERATE(true, false);
    const triangulations::Known known = sphere ? triangulations::sphere_known(1) : triangulations::torus_known(3, 1);
    const Mesh mesh = sphere ? triangulations::sphere(5) : triangulations::torus(120, 42);
    const Errors e = errors(Smooth(mesh, known.normal), known);
    CAPTURE(sphere, mesh.points.size(), e.smooth, e.flat);
    CHECK(e.flat / e.smooth > 100);
}

TEST_CASE("over a sampled teapot the smooth surface is a hundred times nearer than the facets", "[converges]") {
    const SurfaceModel model = models::teapot();
    // Distances to the patches, sorted, of points over facets and on them; normals are those that the vertices alone
    // tell.
    struct Distances {
        std::vector<double> smooth, flat;
    };
    const auto distances = [&](int n) {
        Distances d;
        for (int p = 0; p < model.num_patches(); ++p) {
            const ParametricSurface& patch = model.patch(p);
            const triangulations::Sampled sampled = triangulations::sampled(patch, n);
            const Triangulation surface(triangulations::soup(sampled.mesh));
            const SmoothSupport support = surface.support();
            for (int t = 0; t < surface.mesh().num_triangles(); ++t) {
                const Triangle& v = sampled.mesh.triangles[t];
                if (!sampled.is_inner(v[0]) || !sampled.is_inner(v[1]) || !sampled.is_inner(v[2])) continue;
                for (const auto& [b, c] : {std::pair(1.0 / 3, 1.0 / 3), {0.5, 0.5}, {0.5, 0.0}, {0.2, 0.6}}) {
                    const auto& points = sampled.mesh.points;
                    const Eigen::Vector2d near =
                        (1 - b - c) * sampled.uv[v[0]] + b * sampled.uv[v[1]] + c * sampled.uv[v[2]];
                    const Vector3d flat = (1 - b - c) * points[v[0]] + b * points[v[1]] + c * points[v[2]];
                    d.smooth.push_back(project_beyond(patch, support.point(t, b, c), near).distance);
                    d.flat.push_back(project_beyond(patch, flat, near).distance);
                }
            }
        }
        std::sort(d.smooth.begin(), d.smooth.end());
        std::sort(d.flat.begin(), d.flat.end());
        return d;
    };
    const auto median = [](const std::vector<double>& d) { return d[d.size() / 2]; };
    const Distances coarse = distances(24), fine = distances(48);
    CAPTURE(median(coarse.flat), median(coarse.smooth), median(fine.flat), median(fine.smooth));
    CAPTURE(coarse.flat.back(), coarse.smooth.back(), fine.flat.back(), fine.smooth.back());
    CHECK(median(coarse.flat) / median(coarse.smooth) > 200);
    CHECK(median(fine.flat) / median(fine.smooth) > 500);
    CHECK(fine.flat.back() / fine.smooth.back() > 150);
    CHECK(median(coarse.smooth) / median(fine.smooth) > 6);
    // The farthest: of third order, and nearer than the facets by as much on the coarse mesh as well.
    CHECK(coarse.flat.back() / coarse.smooth.back() > 35);
    CHECK(coarse.smooth.back() / fine.smooth.back() > 8);
}

TEST_CASE("patches meet with one tangent plane along their edges", "[property]") {
    const Case c = case_of(GENERATE(0, 1));
    const Smooth s(c.mesh, c.known.normal);
    double largest = 0;
    for (int h = 0; h < 3 * s.size(); ++h) {
        const int g = s.mesh.twin(h);
        if (g < h) continue;
        for (const double x : {0.1, 0.3, 0.5, 0.7, 0.9}) {
            const Vector3d n = side_normal(s.support->patch(h / 3), h % 3, x),
                           m = side_normal(s.support->patch(g / 3), g % 3, 1 - x);
            largest = std::max(largest, std::atan2(n.cross(m).norm(), n.dot(m)));
        }
    }
    CAPTURE(c.name, largest);
    CHECK(largest < 1e-6);
}

TEST_CASE("patches of random normals stay as near to their facets as asked", "[property]") {
    const double bulge = GENERATE(0.001, 0.01);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> number(-1, 1);
    const auto normal = [&](const Vector3d& p) {
        return Vector3d((p.normalized() + 0.8 * Vector3d(number(random), number(random), number(random))).normalized());
    };
    const Smooth s(triangulations::sphere(3), normal, {.largest_bulge = bulge});
    double largest = 0, curves = 0;
    for_each_sample(s, 8, [&](int t, const GregoryPatch& patch, double b, double c) {
        const Triangle& v = s.triangles.triangles[t];
        const Vector3d p0 = s.triangles.points[v[0]],
                       n = (s.triangles.points[v[1]] - p0).cross(s.triangles.points[v[2]] - p0).normalized();
        largest = std::max(largest, std::abs(n.dot(patch.point(b, c) - p0)));
    });
    for (int h = 0; h < 3 * s.size(); ++h) {
        const Vector3d &a = s.triangles.points[s.mesh.origin(h)], &b = s.triangles.points[s.mesh.target(h)],
                       p = s.support->curve_point(h, 0.5);
        curves = std::max(curves, (p - closest_point(p, a, b, b)).norm());
    }
    CAPTURE(bulge, largest / bulge, curves / bulge);
    CHECK(curves <= bulge * (1 + 1e-9));
    CHECK(largest <= 2 * bulge);
    CHECK(largest > 0.5 * bulge);
}

namespace {

// A sheet of needles with normals at random.
Smooth needles(double squeezed) {
    Mesh sheet = triangulations::graph(8, [](double x, double y) { return 0.1 * std::sin(5 * x) * std::cos(4 * y); });
    for (Vector3d& p : sheet.points) p.x() *= squeezed, p.z() *= squeezed;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> number(-1, 1);
    return Smooth(sheet, [&](const Vector3d&) {
        return Vector3d(Vector3d(0, 0, 2) + Vector3d(number(random), number(random), number(random))).normalized();
    });
}

}  // namespace

TEST_CASE("patches rise no more than about a third of what their facets are wide", "[property]") {
    const double squeezed = GENERATE(1.0, 0.1);
    const Smooth s = needles(squeezed);
    double largest = 0;
    for_each_sample(s, 8, [&](int t, const GregoryPatch& patch, double b, double c) {
        const Triangle& v = s.triangles.triangles[t];
        const Vector3d p0 = s.triangles.points[v[0]], p1 = s.triangles.points[v[1]], p2 = s.triangles.points[v[2]];
        const Vector3d area = (p1 - p0).cross(p2 - p0);
        const double width = area.norm() / std::max({(p1 - p0).norm(), (p2 - p1).norm(), (p0 - p2).norm()});
        largest = std::max(largest, std::abs(area.normalized().dot(patch.point(b, c) - p0)) / width);
    });
    CAPTURE(squeezed, largest);
    CHECK(largest < 0.4);
    CHECK(largest > 0.1);
}

TEST_CASE("curves of edges rise no more than about a quarter of what the facets beside them are wide", "[property]") {
    const double squeezed = GENERATE(1.0, 0.1, 0.003);
    const Smooth s = needles(squeezed);
    double largest = 0;
    for (int h = 0; h < 3 * s.size(); ++h) {
        const Vector3d &a = s.triangles.points[s.mesh.origin(h)], &b = s.triangles.points[s.mesh.target(h)];
        double width = std::numeric_limits<double>::infinity();
        for (const int side : {h, s.mesh.twin(h)})
            if (side >= 0) {
                const Vector3d& c = s.triangles.points[s.mesh.apex(side)];
                width = std::min(width, (c - closest_point(c, a, a + 1e3 * (b - a), a - 1e3 * (b - a))).norm());
            }
        for (const double t : {0.25, 0.5, 0.75}) {
            const Vector3d p = s.support->curve_point(h, t);
            largest = std::max(largest, (p - closest_point(p, a, b, b)).norm() / width);
        }
    }
    CHECK(largest < 0.35);  // what bends either way is estimated
    CHECK(largest > 0.1);
}

TEST_CASE("normals of wedges are exact on a sphere, and one-sided at creases", "[exact]") {
    const Mesh mesh = triangulations::sphere(3, 2);
    const Smooth s(mesh, {});
    for (int t = 0; t < s.size(); ++t)
        for (int k = 0; k < 3; ++k)
            CHECK((s.support->corner_normal(t, k) - mesh.points[mesh.triangles[t][k]] / 2).norm() < 1e-12);
    const Mesh cube = triangulations::cube(3);
    const Smooth c(cube, {});
    for (int t = 0; t < c.size(); ++t) {
        const Triangle& v = cube.triangles[t];
        const Vector3d n =
            (cube.points[v[1]] - cube.points[v[0]]).cross(cube.points[v[2]] - cube.points[v[0]]).normalized();
        for (int k = 0; k < 3; ++k) CHECK((c.support->corner_normal(t, k) - n).norm() < 1e-12);
    }
    // So a cube stays a cube.
    double off = 0;
    for_each_sample(c, 5, [&](int t, const GregoryPatch& patch, double b, double d) {
        off = std::max(off, (patch.point(b, d) - flat_point(c, t, b, d)).cwiseAbs().minCoeff());
    });
    CHECK(off < 1e-14);
}

TEST_CASE("a walk on a convex surface ends at the closest facet", "[property]") {
    const Mesh mesh = triangulations::sphere(3);
    const Smooth s(mesh, {});
    std::vector<int> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0);
    const ClosestTriangle tree(mesh.points, mesh.triangles, all);
    std::mt19937 random(5);
    std::normal_distribution<double> number;
    int exact = 0, tries = 0;
    for (int i = 0; i < 500; ++i) {
        const Vector3d p = (1 + 0.2 * std::abs(number(random))) *
                           Vector3d(number(random), number(random), number(random)).normalized();
        // From a triangle on the same side.
        const int start = static_cast<int>(random() % mesh.triangles.size());
        if (mesh.points[mesh.triangles[start][0]].dot(p) < 0.3) continue;
        const SmoothSupport::Foot foot = s.support->walk(start, p);
        const double distance = (flat_point(s, foot.triangle, foot.b, foot.c) - p).norm();
        ++tries;
        exact += distance <= tree.closest(p).distance * (1 + 1e-9);
        CHECK(foot.b >= 0);
        CHECK(foot.c >= 0);
        CHECK(foot.b + foot.c <= 1 + 1e-12);
        CHECK_FALSE(foot.barred);
    }
    REQUIRE(tries > 100);
    CHECK(exact == tries);
}

TEST_CASE("a walk stops at features and boundaries, and says that there is more beyond", "[exact]") {
    const Mesh mesh = triangulations::cube(3);
    const Smooth s(mesh, {});
    const auto face_of = [&](int t) {
        const Triangle& v = mesh.triangles[t];
        return Vector3d(
            (mesh.points[v[1]] - mesh.points[v[0]]).cross(mesh.points[v[2]] - mesh.points[v[0]]).normalized());
    };
    for (int t = 0; t < s.size(); ++t) {
        const Vector3d n = face_of(t), target = Vector3d(0.5, 0.5, 0.5) - 2 * n;
        const SmoothSupport::Foot inside = s.support->walk(t, Vector3d(0.5, 0.5, 0.5) + 0.7 * n);
        CHECK(face_of(inside.triangle) == n);
        CHECK_FALSE(inside.barred);
        // Beyond an edge of the cube, on the side of another face.
        const Vector3d aside(n.y(), n.z(), n.x());
        const SmoothSupport::Foot stopped = s.support->walk(t, Vector3d(0.5, 0.5, 0.5) + 2 * aside + 0.4 * n);
        CHECK((face_of(stopped.triangle) - n).norm() < 1e-12);
        CHECK(stopped.barred);
        CHECK((flat_point(s, stopped.triangle, stopped.b, stopped.c) - Vector3d(0.5, 0.5, 0.5)).dot(aside) ==
              Approx(0.5));
        CHECK((face_of(s.support->walk(t, target).triangle) - n).norm() < 1e-12);
    }
}
