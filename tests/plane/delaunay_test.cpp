#include "gradus/plane/delaunay.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <stdexcept>

#include "gradus/plane/predicates.hpp"
#include "support/planar_cases.hpp"

using namespace gradus;
using namespace gradus::planar_cases;

namespace {

using Edge = std::array<int, 2>;

double shoelace(const PlanarDomain& domain) {
    double area = 0;
    for (const auto& [a, b] : domain.segments) {
        const Vector2d p = domain.points[a], q = domain.points[b];
        area += (p.x() * q.y() - p.y() * q.x()) / 2;
    }
    return area;
}

/// What every mesh owes its domain: points kept, exact orientation, segments as its boundary and nothing else, area.
/// The loops of the domain must run counter-clockwise outside and clockwise inside.
void require_sound(const PlanarMesh& mesh, const PlanarDomain& domain) {
    REQUIRE(mesh.points.size() >= domain.points.size());
    for (std::size_t i = 0; i < domain.points.size(); ++i) REQUIRE(mesh.points[i] == domain.points[i]);
    REQUIRE(mesh.hints.size() == mesh.points.size());
    std::map<Edge, int> uses;
    double area = 0;
    for (const auto& t : mesh.triangles) {
        REQUIRE(orient2d(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]) > 0);
        const Vector2d e = mesh.points[t[1]] - mesh.points[t[0]], f = mesh.points[t[2]] - mesh.points[t[0]];
        area += (e.x() * f.y() - e.y() * f.x()) / 2;
        for (int k = 0; k < 3; ++k) REQUIRE(++uses[{t[k], t[(k + 1) % 3]}] == 1);
    }
    CHECK(area == Approx(shoelace(domain)).epsilon(1e-10));
    std::map<Edge, int> boundary;
    for (const auto& [edge, count] : uses)
        if (uses.count({edge[1], edge[0]}) == 0)
            boundary[{std::min(edge[0], edge[1]), std::max(edge[0], edge[1])}] = count;
    for (const auto& [a, b] : domain.segments) REQUIRE(boundary.count({std::min(a, b), std::max(a, b)}) == 1);
    REQUIRE(boundary.size() == domain.segments.size());
    CHECK_FALSE(mesh.statistics.splits_bounded);
    CHECK_FALSE(mesh.statistics.flips_bounded);
    CHECK(mesh.statistics.lost_walks == 0);
}

PlanarDomain square(const PlaneMetric& metric) {
    PlanarDomain domain;
    add_rectangle(domain, metric, 1, 1);
    return domain;
}

PlanarDomain ring(const PlaneMetric& metric) {
    PlanarDomain domain;
    add_circle(domain, metric, {0, 0}, 1);
    PlanarDomain hole;
    add_circle(hole, metric, {0.2, 0.1}, 0.3);
    const int first = static_cast<int>(domain.points.size());
    domain.points.insert(domain.points.end(), hole.points.begin(), hole.points.end());
    for (const auto& [a, b] : hole.segments) domain.segments.push_back({first + b, first + a});
    return domain;
}

PlanarDomain l_shape(const PlaneMetric& metric) {
    PlanarDomain domain;
    add_polygon(domain, metric, {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}});
    return domain;
}

PlanarDomain comb(const PlaneMetric& metric) {
    std::vector<Vector2d> corners{{0, 0}, {1.9, 0}};
    for (int tooth = 9; tooth >= 0; --tooth) {
        corners.emplace_back(0.2 * tooth + 0.1, 1);
        corners.emplace_back(0.2 * tooth, 1);
        if (tooth == 0) break;
        corners.emplace_back(0.2 * tooth, 0.1);
        corners.emplace_back(0.2 * tooth - 0.1, 0.1);
    }
    PlanarDomain domain;
    add_polygon(domain, metric, corners);
    return domain;
}

/// A pole at v = 0: one segment of length 0 between its corners.
PlanarDomain cone(const PlaneMetric& metric, double angle) {
    PlanarDomain domain;
    add_rectangle(domain, metric, angle, 1);
    return domain;
}

bool at_pole(const Vector2d& p) { return p.y() == 0; }

double ideal_count(double metric_area) { return metric_area / (std::sqrt(3.0) / 4); }

/// Largest distance, relative to the radius, at which a vertex lies inside the circumcircle of a triangle that should
/// be empty.
double deepest_intrusion(const PlanarMesh& mesh) {
    double deepest = 0;
    for (const auto& t : mesh.triangles) {
        const Vector2d a = mesh.points[t[0]], b = mesh.points[t[1]] - a, c = mesh.points[t[2]] - a;
        const double d = 2 * (b.x() * c.y() - b.y() * c.x());
        const Vector2d centre = Vector2d(c.y() * b.squaredNorm() - b.y() * c.squaredNorm(),
                                         b.x() * c.squaredNorm() - c.x() * b.squaredNorm()) /
                                d;
        for (const Vector2d& p : mesh.points) deepest = std::max(deepest, 1 - (p - a - centre).norm() / centre.norm());
    }
    return deepest;
}

}  // namespace

TEST_CASE("Meshes of all domains are sound and nearly unit", "[delaunay][property]") {
    const PlaneMetric metric =
        GENERATE(uniform_metric(0.05), uniform_metric(0.023), radial_metric({0.3, 0.4}, 0.01, 0.2));
    const PlanarDomain domain = GENERATE_COPY(square(metric), ring(metric), l_shape(metric));
    const PlanarMesh mesh = mesh_domain(domain, metric);
    require_sound(mesh, domain);
    const Facts facts = measure(mesh, metric);
    CHECK(facts.longest < 1.55);
    CHECK(facts.shortest > 0.5);
    CHECK(facts.mean_quality > 0.93);
    CHECK(facts.worst_quality > 0.3);
    CHECK(facts.triangles == Approx(ideal_count(facts.metric_area)).epsilon(0.1));
}

TEST_CASE("A comb is meshed into its teeth, narrow or wide", "[delaunay][property]") {
    const double size = GENERATE(0.3, 0.05, 0.013);
    const PlaneMetric metric = uniform_metric(size);
    const PlanarDomain domain = comb(metric);
    const PlanarMesh mesh = mesh_domain(domain, metric);
    require_sound(mesh, domain);
    const Facts facts = measure(mesh, metric);
    CHECK(facts.longest < std::max(1.5, 0.15 / size));
    if (size < 0.02) CHECK(facts.mean_quality > 0.95);
}

TEST_CASE("In the identity metric the mesh is Delaunay", "[delaunay][property]") {
    const double size = GENERATE(0.07, 0.0311);
    const PlanarMesh mesh = mesh_domain(square(uniform_metric(size)), uniform_metric(size));
    CHECK(deepest_intrusion(mesh) < 1e-9);
}

TEST_CASE("In the identity metric the mesh of a domain with a hole is locally Delaunay", "[delaunay][property]") {
    const PlaneMetric metric = uniform_metric(0.04);
    const PlanarMesh mesh = mesh_domain(ring(metric), metric);
    std::map<Edge, int> apex;
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) apex[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
    for (const auto& [edge, p] : apex) {
        const auto twin = apex.find({edge[1], edge[0]});
        if (twin == apex.end()) continue;
        // Opposite angles of the two triangles add up to no more than pi.
        const Vector2d from = mesh.points[edge[0]], to = mesh.points[edge[1]];
        const auto cosine = [&](int q) {
            return (from - mesh.points[q]).normalized().dot((to - mesh.points[q]).normalized());
        };
        REQUIRE(std::acos(cosine(p)) + std::acos(cosine(twin->second)) < kPi + 1e-6);
    }
}

TEST_CASE("Uniform meshes are mostly regular", "[delaunay]") {
    const PlaneMetric metric = uniform_metric(1 / 70.0);
    const Facts facts = measure(mesh_domain(square(metric), metric), metric);
    CHECK(facts.mean_quality > 0.98);
    CHECK(facts.worst_quality > 0.5);
    CHECK(facts.regular > 0.9);
}

TEST_CASE("Sizes may range over a factor of fifty", "[delaunay]") {
    const PlaneMetric metric = radial_metric({0, 0}, 0.0008, 0.04 / 1.4142);
    const PlanarDomain domain = square(metric);
    const PlanarMesh mesh = mesh_domain(domain, metric);
    require_sound(mesh, domain);
    const Facts facts = measure(mesh, metric);
    CHECK(facts.mean_quality > 0.96);
    CHECK(facts.longest < 1.5);
    CHECK(facts.shortest > 0.5);
    CHECK(facts.triangles == Approx(ideal_count(facts.metric_area)).epsilon(0.05));
}

TEST_CASE("A size map with wild jumps still gives a sound mesh", "[delaunay][property]") {
    const PlaneMetric metric = [](const Vector2d& p, int&) {
        const double h = std::abs(p.x() - 0.5) < 0.1 && p.y() > 0.3 ? 0.002 : 0.1;
        return Matrix2d(Matrix2d::Identity() / (h * h));
    };
    const PlanarDomain domain = square(metric);
    const PlanarMesh mesh = mesh_domain(domain, metric);
    require_sound(mesh, domain);
    CHECK(measure(mesh, metric).mean_quality > 0.8);
}

TEST_CASE("A scaling by powers of two of the plane gives the same mesh exactly", "[delaunay][exact]") {
    const PlaneMetric isotropic = uniform_metric(0.06);
    const PlanarDomain domain = ring(isotropic);
    const PlanarMesh expected = mesh_domain(domain, isotropic);
    const Vector2d scale =
        GENERATE(Vector2d(1024, 0.5), Vector2d(0x1p-20, 0x1p-20), Vector2d(0x1p20, 0x1p20), Vector2d(0x1p-10, 0x1p3));
    PlanarDomain scaled = domain;
    for (Vector2d& p : scaled.points) p = p.cwiseProduct(scale);
    const Matrix2d m = (scale.cwiseProduct(scale) * 0.06 * 0.06).cwiseInverse().asDiagonal();
    const PlanarMesh mesh = mesh_domain(scaled, constant_metric(m));
    REQUIRE(mesh.points.size() == expected.points.size());
    CHECK(mesh.triangles == expected.triangles);
}

TEST_CASE("An anisotropic constant metric gives what a linear map of the isotropic mesh would",
          "[delaunay][property]") {
    const Matrix2d map =
        GENERATE(Matrix2d(Matrix2d{{1, 0.7}, {0, 0.5}}), Matrix2d(Matrix2d{{0.001, 0}, {0, 1}}),
                 Matrix2d(Matrix2d{{0.6, -0.8}, {800, 600}}), Matrix2d(Matrix2d{{30, 29}, {0.3, 0.31}}));
    const PlaneMetric isotropic = uniform_metric(0.04);
    const PlanarDomain domain = ring(isotropic);
    const Facts expected = measure(mesh_domain(domain, isotropic), isotropic);
    PlanarDomain mapped = domain;
    for (Vector2d& p : mapped.points) p = map * p;
    const Matrix2d inverse = map.inverse();
    const PlaneMetric metric = constant_metric(inverse.transpose() * inverse / (0.04 * 0.04));
    const PlanarMesh mesh = mesh_domain(mapped, metric);
    require_sound(mesh, mapped);
    const Facts facts = measure(mesh, metric);
    CHECK(facts.mean_quality == Approx(expected.mean_quality).margin(0.015));
    CHECK(facts.triangles == Approx(expected.triangles).epsilon(0.03));
    CHECK(facts.longest < 1.55);
    CHECK(facts.shortest > 0.5);
}

TEST_CASE("A parametrisation stretched a thousand times is meshed as well", "[delaunay]") {
    const PlaneMetric metric = constant_metric(Vector2d(1e6, 1).asDiagonal().toDenseMatrix() * 900);
    PlanarDomain domain;
    add_rectangle(domain, metric, 0.001, 1);
    const PlanarMesh mesh = mesh_domain(domain, metric);
    require_sound(mesh, domain);
    const Facts facts = measure(mesh, metric);
    CHECK(facts.mean_quality > 0.97);
    CHECK(facts.regular > 0.85);
}

TEST_CASE("A collapsed side is met as a point", "[delaunay]") {
    const double angle = GENERATE(0.5, 1.5707963267948966, kPi, 2 * kPi);
    const PlaneMetric metric = polar_metric(0.03);
    const PlanarDomain domain = cone(metric, angle);
    const PlanarMesh mesh = mesh_domain(domain, metric);
    require_sound(mesh, domain);
    const Facts facts = measure(mesh, metric, at_pole);
    CHECK(facts.mean_quality > 0.95);
    CHECK(facts.worst_quality > 0.3);
    CHECK(facts.longest < 1.6);
    CHECK(facts.shortest > 0.5);
    // Points joined to the pole lie about one unit from it, where the sides of the cone do not crowd them out.
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k)
            if (angle > 1 && at_pole(mesh.points[t[k]])) CHECK(mesh.points[t[(k + 1) % 3]].y() / 0.03 < 1.6);
    CHECK(double(mesh.triangles.size()) == Approx(ideal_count(angle / 2 / (0.03 * 0.03))).epsilon(0.1));
}

TEST_CASE("A sphere in longitude and latitude is meshed between its poles, drawn as one segment or several",
          "[delaunay]") {
    const double size = 0.08;
    const PlaneMetric metric = [=](const Vector2d& p, int&) {
        const double c = std::abs(p.y()) < kPi / 2 ? std::cos(p.y()) : 0;
        return Matrix2d(Vector2d(c * c, 1).asDiagonal().toDenseMatrix() / (size * size));
    };
    const auto pole = [](const Vector2d& p) { return std::abs(p.y()) == kPi / 2; };
    const int pieces = GENERATE(1, 4);
    std::vector<Vector2d> corners;
    for (int i = 0; i <= pieces; ++i) corners.emplace_back(2 * kPi * i / pieces, -kPi / 2);
    for (int i = pieces; i >= 0; --i) corners.emplace_back(2 * kPi * i / pieces, kPi / 2);
    PlanarDomain domain;
    add_polygon(domain, metric, corners);
    const PlanarMesh mesh = mesh_domain(domain, metric);
    require_sound(mesh, domain);
    const Facts facts = measure(mesh, metric, pole);
    CHECK(facts.mean_quality > 0.96);
    CHECK(facts.worst_quality > 0.3);
    CHECK(facts.shortest > 0.5);
    CHECK(facts.longest < 1.6);
    CHECK(double(mesh.triangles.size()) == Approx(ideal_count(4 * kPi / (size * size))).epsilon(0.1));
}

TEST_CASE("A boundary far finer than asked for is not taken for a pole", "[delaunay]") {
    PlanarDomain domain;
    add_circle(domain, uniform_metric(0.0005), {0, 0}, 1);
    const PlaneMetric metric = uniform_metric(0.6);
    const PlanarMesh mesh = mesh_domain(domain, metric);
    require_sound(mesh, domain);
    CHECK(mesh.statistics.front_points + mesh.statistics.split_points > 0);
}

TEST_CASE("Random star polygons with random metrics give sound meshes", "[delaunay][property]") {
    const int seed = GENERATE(range(0, 30));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const double stretch = std::pow(10.0, 4 * unit(random) - 2), size = std::pow(10.0, -0.5 - unit(random));
    const double waves = 6 * unit(random), shear = unit(random) - 0.5;
    const PlaneMetric metric = [=](const Vector2d& p, int&) {
        const double h = size * std::pow(2.0, std::sin(waves * p.x()) + std::cos(waves * p.y() / stretch));
        const Matrix2d to_unit{{1 / h, shear / (h * stretch)}, {0, 1 / (h * stretch)}};
        return Matrix2d(to_unit.transpose() * to_unit);
    };
    // Sides are straight and not cut to unit length: the boundary need not be good for the mesh to be sound.
    PlanarDomain domain;
    const int corners = 5 + static_cast<int>(60 * unit(random));
    for (int i = 0; i < corners; ++i) {
        const double r = 0.15 + unit(random), t = 2 * kPi * i / corners;
        domain.points.emplace_back(r * std::cos(t), stretch * r * std::sin(t));
        domain.segments.push_back({i, (i + 1) % corners});
    }
    require_sound(mesh_domain(domain, metric), domain);
}

TEST_CASE("Domains with nothing inside are triangulated as they are", "[delaunay]") {
    PlanarDomain triangle{.points = {{0, 0}, {1, 0}, {0.5, 0.9}}, .segments = {{0, 1}, {1, 2}, {2, 0}}, .hints = {}};
    const PlanarMesh one = mesh_domain(triangle, uniform_metric(1));
    CHECK(one.triangles.size() == 1);
    CHECK(one.points.size() == 3);
    // Nested loops: even-odd keeps the island.
    PlanarDomain nested;
    const PlaneMetric metric = uniform_metric(0.25);
    add_rectangle(nested, metric, 3, 3);
    for (const double inset : {0.75, 1.25}) {
        const double end = 3 - inset;
        add_polygon(nested, metric, {{inset, inset}, {end, inset}, {end, end}, {inset, end}});
    }
    double area = 0;
    const PlanarMesh mesh = mesh_domain(nested, metric);
    for (const auto& t : mesh.triangles) {
        const Vector2d e = mesh.points[t[1]] - mesh.points[t[0]], f = mesh.points[t[2]] - mesh.points[t[0]];
        area += (e.x() * f.y() - e.y() * f.x()) / 2;
    }
    CHECK(area == Approx(9 - 1.5 * 1.5 + 0.5 * 0.5));
}

TEST_CASE("Isolated points become vertices inside and are counted outside", "[delaunay]") {
    const PlaneMetric metric = uniform_metric(0.1);
    PlanarDomain domain = square(metric);
    domain.points.emplace_back(0.431, 0.577);
    domain.points.emplace_back(3, 3);
    const int inner = static_cast<int>(domain.points.size()) - 2;
    const PlanarMesh mesh = mesh_domain(domain, metric);
    require_sound(mesh, domain);
    int uses = 0;
    for (const auto& t : mesh.triangles) uses += t[0] == inner || t[1] == inner || t[2] == inner;
    CHECK(uses >= 4);
    CHECK(mesh.statistics.unused_points == 1);
}

TEST_CASE("The target scales the unit of length", "[delaunay]") {
    const PlaneMetric metric = uniform_metric(0.02), coarse = uniform_metric(0.04);
    const PlanarDomain domain = square(coarse);
    const PlanarMesh expected = mesh_domain(domain, coarse), mesh = mesh_domain(domain, metric, {.target = 2});
    CHECK(mesh.triangles == expected.triangles);
}

TEST_CASE("The metric is asked inside the domain, with the hint of a nearby point", "[delaunay][property]") {
    const PlaneMetric plain = uniform_metric(0.05);
    const PlanarDomain domain = l_shape(plain);
    std::vector<Vector2d> asked;
    double farthest = 0;
    bool outside = false;
    const PlaneMetric metric = [&](const Vector2d& p, int& hint) {
        if (hint >= 0) farthest = std::max(farthest, (p - asked[hint]).norm());
        outside |= p.x() < 0 || p.y() < 0 || p.x() > 2 || p.y() > 2 || (p.x() > 1 && p.y() > 1);
        hint = static_cast<int>(asked.size());
        asked.push_back(p);
        return Matrix2d(Matrix2d::Identity() / (0.05 * 0.05));
    };
    const PlanarMesh mesh = mesh_domain(domain, metric);
    CHECK_FALSE(outside);
    CHECK(farthest < 2 * 0.05);
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
        REQUIRE((asked[mesh.hints[i]] - mesh.points[i]).norm() < 1e-12);
}

TEST_CASE("The same input gives the same mesh", "[delaunay]") {
    const PlaneMetric metric = radial_metric({0.4, 0.4}, 0.01, 0.1);
    const PlanarMesh a = mesh_domain(square(metric), metric), b = mesh_domain(square(metric), metric);
    CHECK(a.points == b.points);
    CHECK(a.triangles == b.triangles);
}

TEST_CASE("What cannot be meshed is refused", "[delaunay]") {
    const PlaneMetric metric = uniform_metric(1);
    const std::vector<Vector2d> points{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {2, 0}, {2, 2}};
    const auto refused = [&](std::vector<Edge> segments) {
        CHECK_THROWS_AS(mesh_domain({.points = points, .segments = segments, .hints = {}}, metric),
                        std::invalid_argument);
    };
    refused({});
    refused({{0, 1}, {1, 2}, {2, 3}});
    refused({{0, 1}, {1, 2}, {2, 9}, {9, 0}});
    refused({{0, 2}, {2, 1}, {1, 3}, {3, 0}});
    refused({{0, 1}, {1, 2}, {2, 3}, {3, 0}});
    refused({{0, 4}, {4, 0}});
    PlanarDomain domain = square(uniform_metric(0.1));
    CHECK_THROWS_AS(mesh_domain(domain, uniform_metric(0.1), {.max_points = 60}), std::length_error);
    CHECK_THROWS_AS(mesh_domain(domain, uniform_metric(0.1), {.target = 0}), std::invalid_argument);
    CHECK_THROWS_AS(mesh_domain(domain, uniform_metric(std::numeric_limits<double>::quiet_NaN())),
                    std::invalid_argument);
    domain.points.push_back(domain.points[3]);
    CHECK_THROWS_AS(mesh_domain(domain, uniform_metric(0.1)), std::invalid_argument);
}
